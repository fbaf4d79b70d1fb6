// SPDX-License-Identifier: Apache-2.0
//
// --mask and the calibration's mask: what shows the vehicle itself is not used.
#include "stereogrid/io/image_file.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using Mask = FolderTest;

constexpr int masked_from{70};

/// Black from the row on.
void put_mask(const fs::path& path, int width = 160, int height = 100, int from = masked_from) {
  Image<std::uint8_t> mask{width, height, 255};
  for (int v{from}; v < height; ++v) std::fill_n(mask.row(v), width, std::uint8_t{0});
  io::write_png(path, mask);
}

int matched_from(const fs::path& run, int first_row) {
  const Arrays stages{io::read_npz(run / "stages" / "000001.npz")};
  int matched{0};
  for (const char* which : {"obstacle_disparity", "road_disparity"}) {
    const auto disparity{stages.at(which).to_image<float>()};
    for (const auto [u, v] : raster(0, disparity.width(), first_row, disparity.height()))
      matched += disparity(u, v) != 0 ? 1 : 0;
  }
  return matched;
}

const std::string scene{small_scene("street", "&frames=3")};

TEST_F(Mask, OfTheCommandLineIsUsed) {
  const fs::path mask{folder / "mask.png"};
  put_mask(mask);
  const fs::path plain{folder / "plain"};
  const fs::path masked{folder / "masked"};
  run_well({"run", scene, "--out", plain, "--save-stages"});
  run_well({"run", scene, "--out", masked, "--save-stages", "--mask", mask});
  EXPECT_GT(matched_from(plain, masked_from), 500);
  EXPECT_EQ(matched_from(masked, masked_from), 0);
  EXPECT_GT(matched_from(masked, masked_from - 20), 500);
  EXPECT_EQ(json_of(masked / "run.json")["input"]["mask"], fs::weakly_canonical(mask).string());
  EXPECT_EQ(json_of(plain / "run.json")["input"]["mask"], "");
  run_well({"evaluate", masked});
}

TEST_F(Mask, OfTheCalibrationStandsBesideItAndGivesWayToTheCommandLines) {
  const fs::path drive{folder / "drive"};
  run_well({"simulate", scene, "--out", drive});
  fs::create_directory(drive / "masks");
  put_mask(drive / "masks" / "bonnet.png");
  std::ofstream{drive / "calibration.yaml", std::ios::app} << "mask: masks/bonnet.png\n";
  const Outcome outcome{run_well({"run", drive, "--out", folder / "run", "--save-stages"})};
  EXPECT_THAT(outcome.errors, HasSubstr("bonnet.png, 30.0 % of the image are not used"));
  EXPECT_EQ(matched_from(folder / "run", masked_from), 0);
  EXPECT_THAT(run_well({"info", drive}).output, HasSubstr("bonnet.png"));

  put_mask(folder / "other.png", 160, 100, 90);
  run_well({"run", drive, "--out", folder / "other", "--save-stages", "--mask", folder / "other.png"});
  EXPECT_GT(matched_from(folder / "other", masked_from), 300);
  EXPECT_EQ(matched_from(folder / "other", 90), 0);
}

TEST_F(Mask, WhatCannotBeOneIsRefused) {
  const auto error_text = [&](const std::string& input, const std::string& mask) {
    const std::string errors{errors_of(65, {"run", input, "--out", folder / "run", "--mask", mask})};
    EXPECT_FALSE(fs::exists(folder / "run"));
    return errors;
  };
  const fs::path drive{folder / "drive"};
  run_well({"simulate", scene, "--out", drive});
  put_mask(folder / "small.png", 80, 100);
  put_mask(folder / "black.png", 160, 100, 0);
  std::ofstream{folder / "text.png"} << "no image";
  std::ofstream{folder / "photo.png", std::ios::binary} << "\xff\xd8\xff\xe0 and so on";
  for (const std::string& input : {scene, drive.string()}) {
    EXPECT_THAT(error_text(input, (folder / "none.png").string()), HasSubstr("none.png"));
    EXPECT_THAT(error_text(input, (folder / "small.png").string()),
                HasSubstr("80×100 px, but the images have 160×100"));
    EXPECT_THAT(error_text(input, (folder / "black.png").string()), HasSubstr("masks every pixel"));
    EXPECT_THAT(error_text(input, (folder / "text.png").string()), HasSubstr("text.png"));
    EXPECT_THAT(error_text(input, (folder / "photo.png").string()), HasSubstr("is a JPEG"));
  }
  std::ofstream{drive / "calibration.yaml", std::ios::app} << "mask: [1, 2]\n";
  EXPECT_THAT(errors_of(65, {"info", drive}), HasSubstr("'mask' in line"));
}

TEST_F(Mask, ARunGoesOnWithItsOwnOnly) {
  put_mask(folder / "mask.png");
  const std::string run{folder / "run"};
  run_well({"run", scene, "--out", run, "--frames", "0:1"});
  EXPECT_THAT(errors_of(64, {"run", scene, "--out", run, "--resume", "--mask", folder / "mask.png"}),
              HasSubstr("input/mask"));
}

}  // namespace
}  // namespace stereogrid::app::testing
