// SPDX-License-Identifier: MIT
#include "bench/world/command_line.hpp"
#include "bench/world/executor.hpp"
#include "bench/world/names.hpp"
#include "cli/commands.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <string>
#include <thread>

namespace {

std::string version_text() {
  using namespace maxlogdet;
  return std::string("maxlogdet ") + version() +
         "\ninstruction sets built in:  " + sim::joined(sim::built_in_isas(), " ") +
         "\nsupported by this machine:  " + sim::joined(sim::supported_isas(), " ") +
         "\nactive:                     " + active_isa() + "  (MAXLOGDET_ISA forces one)" +
         "\nhardware threads:           " + std::to_string(std::thread::hardware_concurrency()) +
         (sim::executor() == nullptr ? "  (built without oneTBB: one is used)" : "  (used by oneTBB)");
}

}  // namespace

int main(int argc, char** argv) {
  return maxlogdet::sim::run_program(
      "maxlogdet", "Picks the feature matches that keep a camera-pose least-squares problem best conditioned.", argc,
      argv, [](CLI::App& program) {
        program.set_version_flag("--version", version_text, "Version, instruction sets and threads");
        maxlogdet::cli::add_select_command(program);
        maxlogdet::cli::add_evaluate_command(program);
        maxlogdet::cli::add_demo_command(program);
      });
}
