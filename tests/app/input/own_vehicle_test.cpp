// SPDX-License-Identifier: Apache-2.0
//
// info --propose-mask: finds the vehicle's own bonnet, and nothing that merely stands still.
#include "../../core/support.hpp"
#include "stereogrid/io/image_file.hpp"
#include "support.hpp"

namespace stereogrid::app::testing {
namespace {

using test::Bonnet;

constexpr int frames{36};
constexpr int width{400};
constexpr int height{250};

std::string name_of(int frame) {
  return (frame < 10 ? "00000" : "0000") + std::to_string(frame);
}

/// The images of a drive, changed by `change(frame)`.
void change_images(const fs::path& drive, const auto& change) {
  for (int i{0}; i < frames; ++i) {
    StereoFrame frame;
    frame.left = io::read_grey(drive / "left" / (name_of(i) + ".png"));
    frame.right = io::read_grey(drive / "right" / (name_of(i) + ".png"));
    change(frame);
    io::write_png(drive / "left" / (name_of(i) + ".png"), frame.left);
    io::write_png(drive / "right" / (name_of(i) + ".png"), frame.right);
  }
}

class OwnVehicle : public SharedFolderTest {
 protected:
  static void SetUpTestSuite() {
    SharedFolderTest::SetUpTestSuite();
    run_well({"simulate", "scene:street?width=400&height=250&frames=36", "--out", *folder / "street"});
  }

  [[nodiscard]] fs::path copy(const std::string& name) const {
    fs::path drive{own_ / name};
    fs::copy(*folder / "street", drive, fs::copy_options::recursive);
    return drive;
  }
  [[nodiscard]] fs::path proposed() const { return own_ / "mask.png"; }
  [[nodiscard]] std::string answer(const fs::path& drive, const Words& more = {}) const {
    return run_well(joined({"info", drive, "--propose-mask", proposed()}, more)).output;
  }

  TemporaryFolder own_;
};

TEST_F(OwnVehicle, IsFoundAndItsMaskCanBeGiven) {
  const Bonnet bonnet{200, 34.3};
  const fs::path drive{copy("drive")};
  change_images(drive, [&](StereoFrame& frame) { bonnet.paint(frame); });
  EXPECT_THAT(answer(drive), HasSubstr("The mask is written to"));
  ASSERT_TRUE(fs::exists(proposed()));
  const Image<std::uint8_t> mask{io::read_grey(proposed())};
  int covered{0};
  int missed{0};
  int too_much{0};
  for (const auto [u, v] : raster(width, height)) {
    covered += bonnet.covers(u, v, width) ? 1 : 0;
    missed += bonnet.covers(u, v, width) && mask(u, v) != 0 ? 1 : 0;
    too_much += !bonnet.covers(u, v + 20, width) && mask(u, v) == 0 ? 1 : 0;
  }
  EXPECT_LT(missed, covered / 50);
  EXPECT_LT(too_much, covered / 50) << "more than 20 rows above it";
  run_well({"run", drive, "--out", own_ / "run", "--mask", proposed(), "--frames", "0:2"});
}

TEST_F(OwnVehicle, IsNotInViewOfAnOrdinaryDrive) {
  EXPECT_THAT(answer(copy("drive")), HasSubstr("not in view"));
  EXPECT_FALSE(fs::exists(proposed()));
}

// Another vehicle that keeps its distance, with road before it.
TEST_F(OwnVehicle, IsNotWhatKeepsItsDistanceAhead) {
  const test::Texture texture{5};
  const fs::path drive{copy("drive")};
  change_images(drive, [&](StereoFrame& frame) {
    for (const auto [u, v] : raster(120, 280, 110, 190)) {
      frame.left(u, v) = static_cast<std::uint8_t>(texture.at(u, v));
      frame.right(u - 20, v) = static_cast<std::uint8_t>(texture.at(u, v));
    }
  });
  static_cast<void>(answer(drive));
  EXPECT_FALSE(fs::exists(proposed()));
}

// Poses of a drive with the images of one place: drift of a satellite receiver.
TEST_F(OwnVehicle, IsNotWhatAVehicleThatStandsSees) {
  const fs::path drive{copy("drive")};
  const Bonnet bumper{190, 30};  // vehicle ahead, down to the image's edge
  for (const char* side : {"left", "right"}) {
    for (int i{1}; i < frames; ++i) {
      fs::copy_file(drive / side / "000000.png", drive / side / (name_of(i) + ".png"),
                    fs::copy_options::overwrite_existing);
    }
  }
  change_images(drive, [&](StereoFrame& frame) { bumper.paint(frame); });
  for (const char* poses : {"file", "odometry", "none"}) {
    EXPECT_THAT(answer(drive, {"--poses", poses}), HasSubstr("nothing can be said")) << poses;
    EXPECT_FALSE(fs::exists(proposed()));
  }
}

}  // namespace
}  // namespace stereogrid::app::testing
