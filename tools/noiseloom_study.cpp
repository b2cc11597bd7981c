// The program behind `noiseloom export`, `score`, `analyze` and `accuracy`: what needs image libraries and no MPI.
#include "noiseloom_study.h"

#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "noiseloom/core/error.h"

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
    app.parse(argc, argv);
    return status;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? exit_done : exit_user;
  } catch (const UserError& error) {
    const std::size_t count = error.faults().size();
    fmt::print(stderr, "{}\n{} error{}; nothing was done\n", error.what(), count, count == 1 ? "" : "s");
    return exit_user;
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "out of memory: the system gives this process no more (ulimit -v, a container's limit?)\n");
    return exit_environment;
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    return exit_environment;
  }
}

}  // namespace
}  // namespace noiseloom

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a full quota is then an error that is told
  return noiseloom::run(argc, argv);
}
