// render: what noises are worth in a scene.

#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <climits>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/core/child_process.h"
#include "noiseloom/core/console.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/json.h"
#include "noiseloom/core/parallel.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/render/output.h"
#include "noiseloom/render/result.h"
#include "noiseloom/report/render_report.h"
#include "noiseloom_options.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

namespace fs = std::filesystem;

constexpr int exit_expectation = 3;
constexpr int exit_interrupted = 75;

struct RenderArguments {
  std::string scene;
  std::string folder;
  std::string noises;
  std::vector<std::string> overrides;
  int threads = 0;
  bool plan = false;
  bool overwrite = false;
  bool help_scene = false;
  ResultOptions result;
};

struct Stopped {};  // a signal came while a texture was made

// Runs `noiseloom generate`, which goes on with what is there and does nothing where that is finished.
class TextureMaker {
 public:
  TextureMaker(std::string program, int threads, const ResultOptions& result)
      : program_(std::move(program)), threads_(threads), result_(result) {}

  void operator()(const std::string& config, const std::vector<std::string>& changes, const std::string& output) {
    const bool is_there = fs::exists(output);
    fs::create_directories(fs::path(output).parent_path());
    std::string path = config;
    if (config.find('\n') != std::string::npos) {  // its text
      path = fs::path(output).replace_extension(".toml").string();
      OutputFiles files(posix_file_ops(), true);
      files.write(path, config);
      files.commit();
    }
    if (!is_there) result_.say(fmt::format("making {} from {}", output, path));
    std::vector<std::string> words = {program_, "generate", path, "-o", output, "--progress", "none"};
    for (const std::string& change : changes) words.insert(words.end(), {"--set", change});
    if (threads_ > 0) words.insert(words.end(), {"--threads", std::to_string(threads_)});
    if (is_there) words.push_back("--resume");
    const ChildResult result = run_child(words, std::numeric_limits<double>::infinity(), signals_);
    if (result.end != ChildResult::End::exited) throw Stopped{};
    if (result.status != 0)
      throw EnvironmentError(fmt::format("{}: generate of {} ended with status {}", output, path, result.status));
  }

  // Another command that shares the folder makes what is to be there: it is left to that.
  void wait_for_other(const std::string& output) {
    if (std::exchange(waited_for_, output) != output)
      result_.say(fmt::format("waiting for another command that makes {}", output));
    signals_.wait_for_child(0.1);
    if (signals_.come()) throw Stopped{};
  }

 private:
  std::string program_;
  int threads_;
  const ResultOptions& result_;
  std::string waited_for_;
  StopSignals signals_;
};

std::vector<render::Noise> open_noises(const render::Scene& scene, const RenderArguments& arguments) {
  const std::string folder =
      arguments.noises.empty() ? (fs::path(arguments.folder) / "noise").string() : arguments.noises;
  TextureMaker maker(program_beside(), arguments.threads, arguments.result);
  std::vector<render::Noise> noises;
  for (const render::NoiseSpec& spec : scene.noises)
    noises.push_back(render::open_noise(spec, folder, std::ref(maker),
                                        [&maker](const std::string& output) { maker.wait_for_other(output); }));
  return noises;
}

// What is printed at the end, as text and as members of an object; and whether all hold.
struct ExpectationWords {
  std::string text;
  std::string json;
  bool all_hold = true;
};

ExpectationWords words_of(const std::vector<render::ExpectationResult>& results) {
  ExpectationWords words;
  for (const render::ExpectationResult& one : results) {
    words.text += fmt::format("{:<9}  {}\n           {}\n", render::to_string(one.outcome), one.text, one.found);
    words.json += (words.json.empty() ? "" : ", ") +
                  json_object({{"outcome", render::to_string(one.outcome)}, {"text", one.text}, {"found", one.found}});
    words.all_hold = words.all_hold && one.outcome == render::Outcome::holds;
  }
  return words;
}

int run_plan(const render::Scene& scene) {
  std::vector<render::Noise> noises;
  for (const render::NoiseSpec& spec : scene.noises) noises.push_back(render::describe_noise(spec));
  fmt::print("{}", render::plan_text(render::plan_passes(render::all_passes(), scene, noises)));
  for (const std::string& note : render::notes_of_reading(scene, noises)) fmt::print("note: {}\n", note);
  return 0;
}

int run_render(const RenderArguments& arguments) {
  if (arguments.help_scene) {
    fmt::print("{}", render::describe_scene_settings());
    return 0;
  }
  if (arguments.scene.empty()) throw UserError("command line", "SCENE.toml is required; see noiseloom render --help");
  const render::Scene scene = render::load_scene(arguments.scene, arguments.overrides);
  if (arguments.plan) return run_plan(scene);
  refuse_unfit_folder(arguments.folder);
  OutputFiles output(posix_file_ops(), arguments.overwrite);
  const auto in_folder = [&](const char* name) { return (fs::path(arguments.folder) / name).string(); };
  output.check({in_folder("results.csv"), in_folder("curves.csv"), in_folder("spectra.csv"), in_folder("plan.json"),
                in_folder("report.html")});
  // Of pictures nobody knows before the end how they are called.
  for (const char* name : {"pictures", "page"}) {
    std::error_code absent;
    if (!arguments.overwrite && fs::exists(in_folder(name), absent) && !fs::is_empty(in_folder(name), absent)) {
      throw UserError(in_folder(name), "holds pictures of another run; --overwrite replaces them");
    }
  }
  const std::vector<render::Noise> noises = open_noises(scene, arguments);
  const auto print_notes = [&](std::span<const std::string> notes) {
    if (!arguments.result.quiet)
      for (const std::string& note : notes) print_error(fmt::format("note: {}\n", note));
  };
  const std::vector<std::string> known_before = render::notes_of_reading(scene, noises);
  print_notes(known_before);
  ThreadPool pool(arguments.threads > 0 ? arguments.threads : num_available_processors());
  const render::Result result = render::render(scene, noises, pool);
  print_notes(std::span(result.notes).subspan(known_before.size()));
  const std::vector<render::ExpectationResult> expectations = render::check_expectations(scene, result);
  render::add_outputs(scene, result, arguments.folder, output);
  add_render_report(scene, result, expectations, render::to_toml(scene), report_origin(), arguments.folder, output);
  output.commit();
  std::vector<render::PlannedPass> planned;
  for (const render::PassResult& pass : result.passes) planned.push_back(pass.planned);
  const ExpectationWords words = words_of(expectations);
  const std::string report = in_folder("report.html");
  print_result(
      arguments.result,
      fmt::format("{}\n{}\n{}wrote {}\n", render::plan_text(planned), render::results_text(result), words.text, report),
      fmt::format("{{\"report\": {}, \"results\": {}, \"expectations\": [{}]}}\n", json_string(report),
                  json_string(in_folder("results.csv")), words.json));
  return words.all_hold ? 0 : exit_expectation;
}

}  // namespace

void add_render(CLI::App& app, int& status) {
  auto* const command =
      app.add_subcommand("render", "What noises are worth in a scene: errors against the exact truth");
  const auto arguments = std::make_shared<RenderArguments>();
  command->add_option("SCENE", arguments->scene, "Scene (TOML)");
  command->add_option("-o,--output", arguments->folder, "Folder to write to (made if missing)");
  command->add_flag("--plan", arguments->plan, "Say which passes would run, why, and what they take; render nothing");
  command->add_option("--noises", arguments->noises,
                      "Folder of textures that are made from configs, for several scenes (default DIR/noise)");
  command->add_option("--set", arguments->overrides, "Override a setting of the scene: image.frames=16")
      ->allow_extra_args(false);
  command->add_option("--threads", arguments->threads, "Threads; all processors if not given")
      ->check(CLI::PositiveNumber);
  command->add_flag("--overwrite", arguments->overwrite, "Replace files that exist");
  add_result_options(*command, arguments->result, ShowsProgress::yes);
  command->add_flag("--help-scene", arguments->help_scene, "Every setting of a scene");
  command->footer(
      "A scene names effects, noises and filters. Only what it names is simulated; truth is the exact mean of the "
      "same\n"
      "estimate through the same filters, so that errors are those of the noise alone. Textures of configs are made\n"
      "once and kept. With [[expect]] a scene is a test: the exit status is 3 where an expectation does not hold or "
      "is\n"
      "undecided.\n\n"
      "  noiseloom render configs/scenes/quick.toml -o rendered          then open rendered/report.html\n"
      "  noiseloom render configs/scenes/quick.toml --plan               what it would do\n");
  command->callback([arguments, &status] {
    try {
      status = run_render(*arguments);
    } catch (const Stopped&) {
      status = exit_interrupted;
    }
  });
}

}  // namespace noiseloom
