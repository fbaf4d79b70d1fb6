// SPDX-License-Identifier: Apache-2.0
#include "support.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <regex>

namespace stereogrid::app::testing {

Words joined(Words words, const Words& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string quoted(const std::string& word) {
  std::string text{"'"};
  for (const char c : word) text += c == '\'' ? std::string{"'\\''"} : std::string{c};
  return text + "'";
}

Outcome run_tool(const Words& words, const std::string& environment) {
  return run_program(STEREOGRID_TOOL, words, environment);
}

Outcome run_program(const std::string& program, const Words& words, const std::string& environment) {
  const TemporaryFolder folder;
  std::string command{environment + " " + quoted(program)};
  for (const std::string& word : words) command += " " + quoted(word);
  command += " >" + quoted((folder / "out").string()) + " 2>" + quoted((folder / "err").string());
  const int status{std::system(command.c_str())};
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), text_of(folder / "out"),
          text_of(folder / "err")};
}

bool has_node() {
  return std::system("node --version >/dev/null 2>&1") == 0;
}

bool script_fills(const fs::path& report) {
  const fs::path check{fs::path{STEREOGRID_SOURCE_DIR} / "tests" / "app" / "report_check.js"};
  return std::system(("node " + quoted(check.string()) + " " + quoted(report.string())).c_str()) == 0;
}

Outcome run_well(const Words& words) {
  Outcome outcome{run_tool(words)};
  EXPECT_EQ(outcome.exit_code, 0) << outcome.errors;
  return outcome;
}

std::string errors_of(int exit_code, const Words& words, const std::string& environment) {
  const Outcome outcome{run_tool(words, environment)};
  EXPECT_EQ(outcome.exit_code, exit_code) << outcome.errors;
  return outcome.errors;
}

void expect_refused(const Refused& refused) {
  SCOPED_TRACE(::testing::PrintToString(refused.words));
  EXPECT_THAT(errors_of(refused.exit_code, refused.words), AllOf(HasSubstr("stereogrid: "), HasSubstr(refused.said)));
}

std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream{path, std::ios::binary}.rdbuf();
  return text.str();
}

void edit(const fs::path& path, const char* pattern, const std::string& replacement) {
  const std::string text{text_of(path)};
  const std::string edited{std::regex_replace(text, std::regex{pattern}, replacement)};
  EXPECT_NE(edited, text) << pattern;
  std::ofstream{path} << edited;
}

Json json_of(const fs::path& path) {
  return Json::parse(text_of(path));
}

std::vector<Json> lines_of(const fs::path& run, bool with_timing) {
  std::vector<Json> lines;
  std::ifstream file{run / "frames.jsonl"};
  for (std::string line; std::getline(file, line);) {
    if (file.eof()) break;  // half a line: the program is still at it
    lines.push_back(Json::parse(line));
    if (!with_timing) lines.back().erase("timing_ms");
  }
  return lines;
}

void wait_for_frames(const fs::path& run, std::size_t count) {
  const auto deadline{std::chrono::steady_clock::now() + std::chrono::seconds{60}};
  while (lines_of(run).size() < count && std::chrono::steady_clock::now() < deadline) {
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
  }
}

double value_at(const fs::path& run, const std::string& frame, const char* array, double x_m, double y_m) {
  const auto cells{io::read_npz(run / "grids" / (frame + ".npz")).at(array).to_image<float>()};
  const Json grid = json_of(run / "run.json").at("grid");
  const double size_m{grid.at("cell_size_m")};
  return static_cast<double>(cells(static_cast<int>((x_m - grid.at("x_min_m").get<double>()) / size_m),
                                   static_cast<int>((y_m - grid.at("y_min_m").get<double>()) / size_m)));
}

std::vector<std::string> files_in(const fs::path& folder) {
  std::vector<std::string> names;
  if (!fs::is_directory(folder)) return names;
  for (const fs::directory_entry& entry : fs::directory_iterator{folder}) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

void expect_equal_runs(const fs::path& a, const fs::path& b) {
  EXPECT_EQ(lines_of(a, false), lines_of(b, false));
  for (const char* folder : {"grids", "stages"}) {
    ASSERT_EQ(files_in(a / folder), files_in(b / folder));
    for (const std::string& name : files_in(a / folder)) {
      EXPECT_TRUE(text_of(a / folder / name) == text_of(b / folder / name)) << folder << "/" << name << " differ";
    }
  }
}

std::string small_scene(const std::string& name, const std::string& more) {
  return "scene:" + name + "?width=160&height=100" + more;
}

namespace {

int code_of(int status) {
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

}  // namespace

Process::Process(const Words& words, int ignored) : Process{STEREOGRID_TOOL, words, ignored} {}

Process::Process(const std::string& program, const Words& words, int ignored) {
  std::vector<std::string> copies{program};
  copies.insert(copies.end(), words.begin(), words.end());
  std::vector<char*> arguments;
  for (std::string& word : copies) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  id_ = fork();
  if (id_ != 0) return;
  // independent of the test's environment
  for (const int one : {SIGINT, SIGTERM, SIGHUP}) signal(one, one == ignored ? SIG_IGN : SIG_DFL);
  const int nothing{open("/dev/null", O_RDWR)};
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) dup2(nothing, stream);
  execvp(program.c_str(), arguments.data());
  _exit(127);
}

Process::Process(Process&& other) noexcept : id_{std::exchange(other.id_, -1)} {}

Process::~Process() {
  if (id_ < 0) return;
  send(SIGKILL);
  wait();
}

void Process::send(int signal) const {
  kill(id_, signal);
}

int Process::wait() {
  int status{0};
  waitpid(std::exchange(id_, -1), &status, 0);
  return code_of(status);
}

std::optional<int> Process::wait_for(std::chrono::milliseconds limit) {
  const auto end{std::chrono::steady_clock::now() + limit};
  while (std::chrono::steady_clock::now() < end) {
    siginfo_t ended{};
    waitid(P_PID, static_cast<id_t>(id_), &ended, WEXITED | WNOHANG | WNOWAIT);
    if (ended.si_pid == id_) return wait();
    std::this_thread::sleep_for(std::chrono::milliseconds{5});
  }
  return std::nullopt;
}

void Process::wait_until_it_catches_signals() const {
  for (int i{0}; i < 6000; ++i) {
    std::ifstream status{"/proc/" + std::to_string(id_) + "/status"};
    const std::string key{"SigCgt:\t"};
    for (std::string line; std::getline(status, line);) {
      if (!line.starts_with(key)) continue;
      if ((std::stoull(line.substr(key.size()), nullptr, 16) >> (SIGTERM - 1) & 1U) != 0) return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds{10});
  }
}

int shell(const std::string& line) {
  return code_of(std::system(line.c_str()));
}

}  // namespace stereogrid::app::testing
