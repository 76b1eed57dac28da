// SPDX-License-Identifier: MIT
#include "cli/commands.hpp"
#include "sim/frame_reader.hpp"

#include <exception>
#include <iostream>

namespace {

constexpr int exit_bad_input = 2;

int fail(const char* message) {
  std::cerr << "maxlogdet: " << message << '\n';
  return exit_bad_input;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App program("Picks the feature matches that keep a camera-pose least-squares problem best conditioned.");
  program.name("maxlogdet");
  program.require_subcommand(1);
  program.set_version_flag("--version", maxlogdet::version());
  maxlogdet::cli::add_select_command(program);
  maxlogdet::cli::add_info_command(program);
  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);  // --help, --version
    return fail((std::string(error.what()) + " (maxlogdet --help tells the commands and options)").c_str());
  } catch (const maxlogdet::sim::InputError& error) {
    return fail(error.what());
  } catch (const std::exception& error) {
    return fail(error.what());
  }
  return std::cout.flush() ? 0 : fail("standard output could not be written");
}
