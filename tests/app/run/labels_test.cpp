// SPDX-License-Identifier: Apache-2.0
//
// Images of the left image's pixels: labels of a semantic segmentation, and masks.
#include "stereogrid/io/image_file.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

constexpr int width_px{160};
constexpr int height_px{100};
constexpr std::uint8_t road{7};
constexpr std::uint8_t wall{12};
constexpr std::uint8_t self{255};

class Labels : public ::testing::Test {
 protected:
  void SetUp() override {
    run_well({"simulate", small_scene("empty", "&frames=3&focal=80&baseline=0.5&camera_height=1.65&pitch_deg=0"),
              "--out", drive(), "--no-truth"});
    std::ofstream{drive() / "calibration.yaml", std::ios::app}
        << "labels: {ignore: [255], passable: [7, 8], obstacle: [12], mover: [24]}\n";
  }
  [[nodiscard]] fs::path drive() const { return folder_ / "drive"; }
  [[nodiscard]] fs::path out(const char* name) const { return folder_ / name; }
  static Image<std::uint8_t> all(std::uint8_t value) {
    Image<std::uint8_t> labels{width_px, height_px};
    labels.fill(value);
    return labels;
  }
  void put(const Image<std::uint8_t>& labels) const {
    fs::create_directories(drive() / "labels");
    for (const char* name : {"000000", "000001", "000002"}) {
      io::write_png(drive() / "labels" / (std::string{name} + ".png"), labels);
    }
  }
  Outcome run(const char* name, const Words& more = {}) const {
    return run_tool(joined({"run", drive(), "--out", out(name), "--poses", "none"}, more));
  }

  TemporaryFolder folder_;
};

TEST_F(Labels, PixelsToIgnoreAreMaskedInTheirFrame) {
  Image<std::uint8_t> labels{all(0)};
  Image<std::uint8_t> mask{all(255)};
  for (int v{60}; v < height_px; ++v) {
    for (int u{90}; u < 130; ++u) {
      labels(u, v) = self;
      mask(u, v) = 0;
    }
  }
  io::write_png(folder_ / "mask.png", mask);
  ASSERT_EQ(run("masked", {"--mask", folder_ / "mask.png"}).exit_code, 0);
  put(labels);
  ASSERT_EQ(run("labelled").exit_code, 0);
  expect_equal_runs(out("masked"), out("labelled"));
  ASSERT_EQ(run("plain", {"--labels", drive() / "left"}).exit_code, 0);  // names of other values
  put(all(0));
  io::write_png(drive() / "labels" / "000000.png", labels);
  ASSERT_EQ(run("first").exit_code, 0);
  const auto grid = [this](const char* name, const char* frame) {
    return text_of(out(name) / "grids" / (std::string{frame} + ".npz"));
  };
  EXPECT_EQ(grid("first", "000000"), grid("masked", "000000"));
  EXPECT_NE(grid("first", "000001"), grid("masked", "000001"));
}

TEST_F(Labels, AreASourceToFuse) {
  Image<std::uint8_t> labels{all(road)};
  for (int v{0}; v < 68; ++v) {  // a wall whose foot is 7.5 m ahead, 80 · 1.65 / (67.5 − 50)
    for (int u{0}; u < width_px; ++u) labels(u, v) = wall;
  }
  put(labels);
  const Outcome fused{run("fused", {"--fuse", "labels", "--set", "fusion.stereo_confidence=0"})};  // labels alone
  ASSERT_EQ(fused.exit_code, 0) << fused.errors;
  EXPECT_EQ(json_of(out("fused") / "run.json").at("fuse").at("source"), "labels");
  const auto observed = [&](double x_m) { return value_at(out("fused"), "000001", "observed", x_m, 0); };
  EXPECT_GT(observed(7.5), 0.6);
  EXPECT_LT(observed(5), 0.35);
  EXPECT_NEAR(observed(9), 0.5, 0.01);
}

TEST_F(Labels, ProblemsAreNamed) {
  put(Image<std::uint8_t>{80, 50});
  EXPECT_THAT(run("size").errors, HasSubstr("has 160×100 px, but"));
  fs::remove_all(drive() / "labels");
  EXPECT_THAT(run("none", {"--fuse", "labels"}).errors, HasSubstr("has no labels."));
  EXPECT_THAT(run("no_folder").errors, HasSubstr("there is no folder labels/"));
  put(all(road));
  fs::remove(drive() / "labels" / "000002.png");
  EXPECT_THAT(run("some", {"--fuse", "labels"}).errors, HasSubstr("has images of 2 of 3 frames"));
  EXPECT_THAT(lines_of(out("some")).at(2).at("warnings").dump(), HasSubstr("stereo alone: no labels"));
  for (const auto& [classes, problem] :
       {std::pair{"{ignore: [7], mover: [7]}", "listed twice"},
        std::pair{"{ignore: [70000]}", "not an integer in 0 … 65535"}, std::pair{"{sky: [1]}", "unknown key"}}) {
    edit(drive() / "calibration.yaml", "labels: .*", std::string{"labels: "} + classes);
    EXPECT_THAT(errors_of(65, {"info", drive()}), HasSubstr(problem)) << classes;
  }
}

// --mask and the calibration's mask: what shows the vehicle itself is not used.

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

  put_mask(folder / "inverted.png", 160, 100, 40);
  EXPECT_THAT(run_well({"info", drive, "--mask", folder / "inverted.png"}).output,
              AllOf(HasSubstr("60.0 % of the image are not used, the larger part"), HasSubstr("usable")));
  put_mask(folder / "white.png", 160, 100, 100);
  for (const auto& [mask, said] :
       {std::pair{"inverted.png", "is this one inverted?"}, {"white.png", "no such pixel"}}) {
    EXPECT_THAT(run_well({"run", scene, "--frames", ":0", "--mask", folder / mask, "--out", folder / said}).errors,
                HasSubstr(said));
  }
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
