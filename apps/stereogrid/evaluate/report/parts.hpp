// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace stereogrid::app::report {

// The files of this folder, as the build has put them into the program.
extern const char* const page_html;
extern const char* const page_css;
extern const char* const charts_js;
extern const char* const page_js;

}  // namespace stereogrid::app::report
