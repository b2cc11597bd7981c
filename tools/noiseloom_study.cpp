// The program behind `noiseloom export`, `score`, `analyze` and `accuracy`: what needs image libraries and no MPI.
#include "noiseloom_study.h"

#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>

#include "noiseloom/core/error.h"
#include "noiseloom/core/standard_streams.h"

namespace noiseloom {
namespace {

constexpr int exit_done = 0;
constexpr int exit_environment = 1;
constexpr int exit_user = 2;

int run(int argc, char** argv) {
  CLI::App app("Look at sampling-noise textures, score them, and turn run files into images", "noiseloom");
  app.require_subcommand(1);
  add_export(app);
  add_score(app);
  add_analyze(app);
  int status = exit_done;
  add_accuracy(app, status);
  try {
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (app.exit(error) != 0) return exit_user;  // 0: the help was asked for, and is printed
    }
    flush_standard_output();
    return status;
  } catch (const UserError& error) {
    const std::size_t count = error.faults().size();
    fmt::print(stderr, "{}\n{} error{}; nothing was done\n", error.what(), count, count == 1 ? "" : "s");
    return exit_user;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return exit_environment;
  }
}

}  // namespace
}  // namespace noiseloom

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a full quota is then an error that is told
  noiseloom::reserve_standard_streams();
  return noiseloom::run(argc, argv);
}
