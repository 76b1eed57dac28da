// SPDX-License-Identifier: MIT
#pragma once

#include "bench/world/scene.hpp"
#include "tests/support/support.hpp"
#include "tests/support/text_folder.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace maxlogdet::test {

/// How a run of the program ended.
struct Outcome {
  int exit_code;
  std::string out;
  std::string err;
};

/// Runs the program in a folder of its own.
class Program : public TextFolder {
 protected:
  Program() : Program("maxlogdet", MAXLOGDET_PROGRAM) {}
  Program(std::string name, std::string command) : name_(std::move(name)), command_(std::move(command)) {
    std::filesystem::create_directories(path("frames"));
  }

  // `environment` as in the shell: "NAME=value ".
  Outcome run(const std::string& arguments, const std::string& environment = "") const {
    return run_script(environment + command_ + " " + arguments + " >out.txt 2>err.txt </dev/null");
  }

  // A script for the shell, in the folder; what the program says goes to out.txt and err.txt.
  Outcome run_script(const std::string& script) const {
    const int status = std::system(("cd '" + folder_ + "'\n" + script).c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, text_of(path("out.txt")), text_of(path("err.txt"))};
  }

  // tools/draw, in the folder.
  Outcome draw(const std::string& paths, const std::string& environment = "") const {
    return run_script(environment + "python3 -B '" MAXLOGDET_TOOLS "/draw' " + paths +
                      " >out.txt 2>err.txt </dev/null");
  }

  std::vector<nlohmann::json> run_json(const std::string& arguments) const {
    const Outcome outcome = run(arguments + " --json --repeat 2");
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    std::istringstream lines(outcome.out);
    std::vector<nlohmann::json> objects;
    for (std::string line; std::getline(lines, line);) objects.push_back(nlohmann::json::parse(line));
    return objects;
  }

  void expect_refused(const Outcome& outcome, const std::string& message) const {
    EXPECT_EQ(outcome.exit_code, 2);
    EXPECT_EQ(outcome.out, "") << "no partial output";
    EXPECT_EQ(outcome.err.rfind(name_ + ": ", 0), 0U) << outcome.err;
    EXPECT_NE(outcome.err.find(message), std::string::npos) << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }

  // A synthetic frame in the frame format, `n` matches.
  void write_frame(const std::string& name, std::size_t n, const std::string& more = "") const {
    const sim::Frame frame = make_scene(sim::Scene::euroc_like, n, Random().seed());
    std::ofstream file(folder_ + "/frames/" + name);
    file.precision(17);
    file << "# fx,fy,cx,cy,bf: " << frame.camera.fx << ',' << frame.camera.fy << ',' << frame.camera.cx << ','
         << frame.camera.cy << ',' << frame.camera.bf << "\n# image width,height: 752,480\n# Tcw_prior: ";
    for (std::size_t i = 0; i < 12; ++i) file << (i == 0 ? "" : ",") << frame.T_cw_prior[i];
    file << "\nmp_id,X,Y,Z,u,v,u_right,inv_sigma2\n";
    for (const sim::Match& m : frame.matches) {
      file << 1000 + m.map_point_id << ',' << m.point[0] << ',' << m.point[1] << ',' << m.point[2] << ',' << m.u << ','
           << m.v << ',' << m.u_right << ',' << m.inv_sigma2 << '\n';
    }
    file << more;
  }

 private:
  std::string name_;
  std::string command_;  // for the shell
};

}  // namespace maxlogdet::test
