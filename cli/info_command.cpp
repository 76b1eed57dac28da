// SPDX-License-Identifier: MIT
#include "bench/world/names.hpp"
#include "cli/commands.hpp"

#include <maxlogdet/maxlogdet.hpp>

#include <cstdlib>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

namespace maxlogdet::cli {
namespace {

void print_info(bool as_json) {
  nlohmann::ordered_json info;
  info["version"] = version();
  info["isa_built_in"] = sim::built_in_isas();
  info["isa_supported"] = sim::supported_isas();
  info["isa_active"] = active_isa();
  info["threads"] = std::thread::hardware_concurrency();
  if (as_json) {
    std::cout << info.dump() << '\n';
    return;
  }
  std::cout << "maxlogdet " << version() << '\n'
            << "instruction sets built in:  " << sim::joined(sim::built_in_isas(), " ") << '\n'
            << "supported by this machine:  " << sim::joined(sim::supported_isas(), " ") << '\n'
            << "active:                     " << active_isa()
            << (std::getenv("MAXLOGDET_ISA") == nullptr ? "  (MAXLOGDET_ISA forces one)\n"
                                                        : "  (as MAXLOGDET_ISA asks)\n")
            << "hardware threads:           " << info["threads"] << '\n';
}

}  // namespace

void add_info_command(CLI::App& program) {
  CLI::App* const command = program.add_subcommand("info", "Version, instruction sets and threads");
  const auto as_json = std::make_shared<bool>(false);
  command->add_flag("--json", *as_json, "One JSON object");
  command->callback([as_json] { print_info(*as_json); });
}

}  // namespace maxlogdet::cli
