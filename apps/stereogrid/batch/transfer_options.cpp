// SPDX-FileCopyrightText: 2026 The stereogrid authors
// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>

#include "batch/transfer.hpp"

namespace stereogrid::app::batch {

void add_transfer_options(CLI::App& command, TransferOptions& options) {
  command
      .add_option("--uri", options.uris,
                  "Inputs whose paths begin with PREFIX are fetched: URI stands for it. Several --uri: the first that "
                  "fits.")
      ->type_name("PREFIX=URI")
      ->expected(1)
      ->take_all();
  command
      .add_option("--fetch", options.fetch,
                  "Command, without a shell, that copies what is at {uri} into the folder {dir}: 'rclone copy {uri} "
                  "{dir}'.")
      ->type_name("COMMAND");
  command
      .add_option("--push", options.push,
                  "Command that copies a finished result, the folder {dir}, elsewhere: 'rclone copy {dir} "
                  "s3:results/{result}'. {uri}, {drive}, {shard}, {result}: the input's, the drive's name, the "
                  "shard's number, a name of its own.")
      ->type_name("COMMAND");
  command.add_option("--scratch", options.scratch, "Folder for what is fetched; left out: that for temporary files.")
      ->type_name("DIR");
  command
      .add_option("--scratch-limit", options.scratch_limit, "That all runners of a machine together may have there.")
      ->type_name("BYTES")
      ->capture_default_str();
  command
      .add_option("--retries", options.retries, "How often each command is tried again, after longer and longer waits.")
      ->type_name("N")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  command.add_option("--transfer-timeout", options.timeout_s, "A try that takes longer is ended.")
      ->type_name("S")
      ->check(CLI::Range(1, 10'000'000))
      ->capture_default_str();
}

TransferOptions with_given(TransferOptions planned, const CLI::App& command, const TransferOptions& given) {
  const auto take = [&](const char* name, auto TransferOptions::*value) {
    if (command.get_option(name)->count() > 0) planned.*value = given.*value;
  };
  take("--uri", &TransferOptions::uris);
  take("--fetch", &TransferOptions::fetch);
  take("--push", &TransferOptions::push);
  take("--scratch", &TransferOptions::scratch);
  take("--scratch-limit", &TransferOptions::scratch_limit);
  take("--retries", &TransferOptions::retries);
  take("--transfer-timeout", &TransferOptions::timeout_s);
  return planned;
}

}  // namespace stereogrid::app::batch
