// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <yaml-cpp/yaml.h>

#include <string>
#include <string_view>

namespace stereogrid::io {

// Other notations than YAML as YAML's nodes, so that one set of readers serves all. Throw InputError; `file`: for
// complaints.

/// OpenCV's XML: elements become keys, words of a leaf a list, <_> elements of a list. Attributes have no effect.
[[nodiscard]] YAML::Node parse_xml(const std::string& file, std::string_view text);

/// [SECTION] and key=value, as ZED's SN*.conf: a group for each section.
[[nodiscard]] YAML::Node parse_sections(const std::string& file, std::string_view text);

/// key=value or key=[numbers; numbers], as Middlebury's calib.txt.
[[nodiscard]] YAML::Node parse_assignments(const std::string& file, std::string_view text);

/// ost.txt of camera_calibration: key 'cameras' with a group of camera_info's keys for each camera.
[[nodiscard]] YAML::Node parse_ost(const std::string& file, std::string_view text);

}  // namespace stereogrid::io
