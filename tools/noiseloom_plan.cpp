// plan: what a run would take, before it is started.

#include "noiseloom_plan.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>

#include "noiseloom/config/config.h"
#include "noiseloom/config/inputs.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom_commands.h"
#include "noiseloom_options.h"

namespace noiseloom {
int run_plan(int argc, char** argv) {
  if (std::string(argv[1]) == "--help-config") {
    fmt::print("{}", describe_settings());
    return exit_done;
  }
  CLI::App app(
      "Says what a run of a config would take, without starting it: memory of each rank and node, space on disk,\n"
      "messages between ranks, time, and which parts of the program the config needs.");
  app.name("noiseloom plan");
  std::string path;
  std::vector<std::string> overrides;
  PlanRequest request;
  ResultOptions result;
  app.add_option("CONFIG", path, "what would be made (TOML; every setting: noiseloom --help-config)")->required();
  app.add_option("--ranks", request.ranks, "MPI ranks to plan for (default 1)");
  app.add_option("--ranks-per-node", request.ranks_per_node, "how many of them share a node (default: all)");
  app.add_option("--threads", request.threads, "threads of each rank (default 1)");
  app.add_option("--set", overrides, "override a setting, as for generate (repeatable)")->allow_extra_args(false);
  add_result_options(app, result, ShowsProgress::no, "in bytes and seconds, with what the text leaves out");
  app.footer(
      "Takes about a second and little memory, whatever the size of the texture. Memory is what a job must ask for: "
      "the\n"
      "peak, at the start, at a save or while going on from one, and mostly within a third of the truth. Speeds are\n"
      "measured on this machine while the plan is made, so plan where you will run; the time is given with the range "
      "in\n"
      "which it mostly lies.");
  if (const auto status = read_options(app, argc - 1, argv + 1)) return *status;
  RunConfig config = load_config(path, overrides);
  if (config.problem.samples.is_image()) read_inputs(config);
  std::optional<MpiSession> session;  // these are measured with a communicator
  if (config.optimizer.method == Method::void_and_cluster || config.optimizer.method == Method::construct) {
    session.emplace(argc, argv);
  }
  const RunPlan plan = plan_run(config, request);
  print_result(result, plan_text(plan), plan_json(plan));
  return exit_done;
}

}  // namespace noiseloom
