// SPDX-License-Identifier: Apache-2.0
#include "stereogrid/io/nav2_map.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <string>

#include "stereogrid/error.hpp"
#include "stereogrid/io/file.hpp"
#include "stereogrid/io/text.hpp"
#include "stereogrid/occupancy_values.hpp"

namespace stereogrid::io {
namespace {

// Values of map_server and its saver for free, occupied and unknown.
constexpr std::uint8_t free_shade{254};
constexpr std::uint8_t occupied_shade{0};
constexpr std::uint8_t unknown_shade{205};
// The saver writes 0.25, by which unknown, (255 − 205)/255 = 0.19608, would be loaded as free.
constexpr const char* thresholds{"occupied_thresh: 0.65\nfree_thresh: 0.196\n"};

std::uint8_t shade_of(float occupancy) {
  const std::int8_t value{occupancy_value(occupancy, OccupancyScale::trinary)};
  if (value < 0) return unknown_shade;
  return value == 0 ? free_shade : occupied_shade;
}

// The uppermost row has the highest y.
std::string pgm_of(View<const float> occupancy) {
  std::string bytes{fmt::format("P5\n{} {}\n255\n", occupancy.width, occupancy.height)};
  for (int iy{occupancy.height - 1}; iy >= 0; --iy) {
    for (int ix{0}; ix < occupancy.width; ++ix) bytes += static_cast<char>(shade_of(occupancy(ix, iy)));
  }
  return bytes;
}

std::string quoted(const std::string& text) {
  YAML::Emitter emitter;
  emitter << YAML::DoubleQuoted << text;
  return emitter.c_str();
}

}  // namespace

void write_nav2_map(const std::filesystem::path& yaml, const GridGeometry& geometry, View<const float> occupancy) {
  if (occupancy.empty() || occupancy.width != geometry.nx || occupancy.height != geometry.ny) {
    throw InputError{printable_path(yaml), "cannot be made of cells that do not have their geometry's size.",
                     "Give nx × ny cells, and at least one."};
  }
  if (yaml.extension() != ".yaml" && yaml.extension() != ".yml") {
    throw InputError{printable_path(yaml), "is not a name for a map.", "Let it end in .yaml."};
  }
  std::filesystem::path image{yaml};
  image.replace_extension(".pgm");
  write_file(image, pgm_of(occupancy));
  write_file(yaml, fmt::format("image: {}\nmode: trinary\nresolution: {}\norigin: [{}, {}, 0]\nnegate: 0\n{}",
                               quoted(image.filename().string()), geometry.cell_size_m, geometry.x_min_m,
                               geometry.y_min_m, thresholds));
}

}  // namespace stereogrid::io
