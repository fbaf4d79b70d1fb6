// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <nlohmann/json.hpp>

#include "../prelude.hpp"
#include "../temporary_folder.hpp"
#include "stereogrid/io/npz.hpp"

namespace stereogrid::app::testing {

using ::testing::AllOf, ::testing::Contains, ::testing::Each, ::testing::ElementsAre, ::testing::HasSubstr,
    ::testing::IsEmpty, ::testing::Not, ::testing::Optional, ::testing::SizeIs, ::testing::StartsWith,
    ::testing::ThrowsMessage;

namespace fs = std::filesystem;
using Json = nlohmann::json;
using Arrays = std::map<std::string, io::NpyArray>;
using Words = std::vector<std::string>;

using tests::TemporaryFolder;

/// Output and exit code of a program.
struct Outcome {
  int exit_code{-1};
  std::string output;
  std::string errors;
};

/// Runs the stereogrid program with words of its command line, each passed on as it is. `environment`: such as
/// "PATH=/x".
Outcome run_tool(const Words& words, const std::string& environment = "");
/// The same for another program.
Outcome run_program(const std::string& program, const Words& words, const std::string& environment = "");

[[nodiscard]] bool has_node();
/// Runs the script of a report of `evaluate` in node; false where it does not fill the page.
[[nodiscard]] bool script_fills(const std::filesystem::path& report);

/// The same; the test fails where it does not end with 0.
Outcome run_well(const Words& words);
/// Messages of the tool, which has to end with this exit code.
std::string errors_of(int exit_code, const Words& words, const std::string& environment = "");

/// A command that the tool rejects, and a part of its message.
struct Refused {
  Words words;
  std::string said;
  int exit_code{64};
};
void expect_refused(const Refused& refused);

/// `words`, and `more` behind them.
[[nodiscard]] Words joined(Words words, const Words& more);

/// A word of the command line.
std::string quoted(const std::string& word);

[[nodiscard]] std::string text_of(const fs::path& path);
/// Replaces what fits `pattern` in a file, at least once.
void edit(const fs::path& path, const char* pattern, const std::string& replacement);
[[nodiscard]] Json json_of(const fs::path& path);
/// frames.jsonl of a run; `with_timing` false: without values that differ between two equal runs.
[[nodiscard]] std::vector<Json> lines_of(const fs::path& run, bool with_timing = true);
/// Waits, for a minute at most, until a run has written `count` frames.
void wait_for_frames(const fs::path& run, std::size_t count);
/// Value of a frame's array (`000001`) in the cell at a place of the vehicle frame.
[[nodiscard]] double value_at(const fs::path& run, const std::string& frame, const char* array, double x_m, double y_m);
/// Names of the files in a folder, in order.
[[nodiscard]] std::vector<std::string> files_in(const fs::path& folder);

/// Expects equal frames, byte by byte: lines but for their timing, grids, stages.
void expect_equal_runs(const fs::path& a, const fs::path& b);

/// A scene small enough for tests; `more` such as "&frames=3".
[[nodiscard]] std::string small_scene(const std::string& name, const std::string& more);

/// Tests with a folder that their suite shares.
struct SharedFolderTest : ::testing::Test {
  static void SetUpTestSuite() { folder = std::make_unique<TemporaryFolder>(); }
  static void TearDownTestSuite() { folder.reset(); }
  static inline std::unique_ptr<TemporaryFolder> folder;
};

/// A program running beside the test; silent.
class Process {
 public:
  /// stereogrid with `words` of its command line. `ignored`: a signal that it is started with ignored, as nohup does;
  /// 0: none.
  explicit Process(const Words& words, int ignored = 0);
  /// Another program, searched in PATH.
  Process(const std::string& program, const Words& words, int ignored = 0);
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  Process(Process&& other) noexcept;
  /// Kills it where it still runs.
  ~Process();

  [[nodiscard]] pid_t id() const { return id_; }
  void send(int signal) const;
  /// Waits for its end: the exit code, or 128 and the signal that killed it, as a shell says it.
  int wait();
  /// The same; none: it has not ended within `limit`.
  std::optional<int> wait_for(std::chrono::milliseconds limit);
  /// Waits until it has a handler for SIGTERM.
  void wait_until_it_catches_signals() const;

 private:
  pid_t id_{-1};
};

/// Runs a line of sh; its exit code.
int shell(const std::string& line);

}  // namespace stereogrid::app::testing
