// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>

#include "cli/console.hpp"
#include "cli/program.hpp"
#include "connect/page.hpp"

namespace stereogrid::app {

void add_completion_command(Command tool) {
  auto shell{std::make_shared<std::string>()};
  const Command command{tool.add_command("completion", "Print a script that completes commands, options and values.")};
  command.footer(
      "Add a line to the start file of the shell:\n"
      "  ~/.bashrc                   source <(stereogrid completion bash)\n"
      "  ~/.zshrc, after compinit    source <(stereogrid completion zsh)\n"
      "  ~/.config/fish/config.fish  stereogrid completion fish | source");
  command.add_option("SHELL", *shell, "Shell that reads the script.").one_of({"bash", "zsh", "fish"}).required();
  command.callback([shell] {
    const auto scripts{completion_scripts()};
    print("{}", std::ranges::find(scripts, fmt::format("/{}.sh", *shell), &server::Asset::path)->bytes);
  });
}

}  // namespace stereogrid::app
