// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
//
// Uses a part of stereogrid::io for each library that it links to: PNG, .npz, YAML and JSON have to link and work.
#include <stereogrid/io/config_file.hpp>
#include <stereogrid/io/file.hpp>
#include <stereogrid/io/image_file.hpp>
#include <stereogrid/io/npz.hpp>

#include <cstdio>
#include <vector>

int main() {
  stereogrid::Image<std::uint8_t> image{7, 5, 100};
  image(3, 2) = 200;
  stereogrid::io::write_png("image.png", image);
  const bool png{stereogrid::io::read_grey("image.png") == image};

  const std::vector<stereogrid::io::NpzArray> arrays{{"image", image}};
  stereogrid::io::write_npz("image.npz", arrays);
  const bool npz{stereogrid::io::read_npz("image.npz").at("image").to_image<std::uint8_t>() == image};

  stereogrid::Config config;
  config.grid.length_m = 33;
  stereogrid::io::write_file("config.yaml", stereogrid::io::to_yaml(config));
  stereogrid::Config read;
  stereogrid::io::load_config("config.yaml", read);
  const bool yaml{read.grid.length_m == 33};
  const bool json{stereogrid::io::to_json(read).find("33") != std::string::npos};

  std::printf("png %d, npz %d, yaml %d, json %d\n", png, npz, yaml, json);
  return png && npz && yaml && json ? 0 : 1;
}
