// SPDX-License-Identifier: MIT
#include "bench/does_the_paper_hold/runs.hpp"
#include "bench/does_the_paper_hold/simulate_command.hpp"
#include "bench/world/command_line.hpp"
#include "bench/world/text.hpp"
#include "cli/commands.hpp"

#include <maxlogdet/version.hpp>

#include <csignal>
#include <exception>
#include <iostream>
#include <string>

namespace {

constexpr int exit_bad_input = 2;
constexpr int exit_interrupted = 130;  // as a shell reports Ctrl-C

int fail(const std::string& message) {
  std::cerr << "maxlogdet: " << maxlogdet::sim::one_line(message) << '\n';
  return exit_bad_input;
}

int flush() { return std::cout.flush() ? 0 : fail("standard output could not be written"); }

}  // namespace

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // beyond a limit of file size, writing fails as on a full disk
  try {
    CLI::App program("Picks the feature matches that keep a camera-pose least-squares problem best conditioned.");
    program.name("maxlogdet");
    program.require_subcommand(0, 1);
    program.set_version_flag("--version", maxlogdet::version());
    maxlogdet::cli::add_select_command(program);
    maxlogdet::cli::add_evaluate_command(program);
    maxlogdet::sim::add_simulate_command(program);
    maxlogdet::cli::add_info_command(program);
    maxlogdet::sim::refuse_empty_values(program);
    try {
      program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) {  // --help, --version
        program.exit(error);
        return flush();
      }
      return fail(std::string(error.what()) + " (see maxlogdet --help, and --help of each command)");
    }
    if (program.get_subcommands().empty())
      return fail("a command is missing: evaluate, select, simulate or info (maxlogdet --help)");
    return flush();
  } catch (const maxlogdet::sim::Interrupted& error) {
    fail(error.what());
    return exit_interrupted;
  } catch (const std::exception& error) {  // sim::InputError among them
    return fail(error.what());
  }
}
