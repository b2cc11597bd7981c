// fastnoise, stbn-scalar, stbn-vector: a line of a published program, run here.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/core/child_process.h"
#include "noiseloom/core/console.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/json.h"
#include "noiseloom/files/generations.h"
#include "noiseloom/files/npy.h"
#include "noiseloom/files/output_files.h"
#include "noiseloom/files/run_lock.h"
#include "noiseloom/published/line.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

constexpr int exit_stopped_line = 75;

// What stands beside the images while they are made, and is removed when they are complete.
class LineFiles {
 public:
  explicit LineFiles(const PublishedLine& line) : line_(line) {}

  std::string config() const { return line_.stem + ".unfinished.toml"; }
  std::string run_file(std::int64_t step) const {
    return line_.stem + (step == 0 ? "" : fmt::format(".{}", step)) + ".unfinished.h5";
  }
  bool has_run_file() const {
    const auto exists = [this](std::int64_t step) { return std::filesystem::exists(run_file(step)); };
    return exists(0) || std::any_of(line_.steps.begin(), line_.steps.end(), exists);
  }
  void remove() const {
    std::vector<std::string> all = {config(), run_file(0)};
    for (const std::int64_t step : line_.steps) all.push_back(run_file(step));
    for (const PublishedInput& input : line_.inputs) all.push_back(input.path);
    std::error_code ignored;
    for (const std::string& file : all) std::filesystem::remove(file, ignored);
  }

 private:
  const PublishedLine& line_;
};

std::string text_of_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

// With the command and the notes in front.
std::string commented_config(const PublishedLine& line) {
  std::string text = "# " + report_origin().command + "\n";
  for (char& c : text)
    if (c == '\n' && &c != &text.back()) c = ' ';
  for (const std::string& note : line.notes) text += "# " + note + "\n";
  return text + "\n" + line.config;
}

// A line that was stopped goes on, without a seed with the one that was drawn for it then. UserError where another line
// was stopped there.
void go_on_from_stopped(PublishedLine& line, const LineFiles& files) {
  const std::string config = files.config();
  if (!std::filesystem::exists(config)) return;
  const std::string text = text_of_file(config);
  if (line.seed_is_drawn) {
    const std::int64_t seed =
        static_cast<std::int64_t>(parse_config(text, config, "", {}, MissingFiles::accepted).problem.seed);
    const std::string drawn = fmt::format("seed    = {}\n", line.seed);
    line.config.replace(line.config.find(drawn), drawn.size(), fmt::format("seed    = {}\n", seed));
    line.seed = seed;
  }
  if (text.ends_with(line.config)) return;
  throw UserError(config, fmt::format("is of another line for the same files, which was stopped; that line, which is "
                                      "its first, goes on with it; or remove it and {}, or choose another name",
                                      files.run_file(0)));
}

class LineRunner {
 public:
  LineRunner(const PublishedLine& line, const LineFiles& files) : line_(line), files_(files) {}

  // The exit status of `noiseloom generate`, which goes on with what is there.
  int make(std::int64_t step) {
    const std::string run_file = files_.run_file(step);
    std::vector<std::string> words = {program_beside(), "generate",   files_.config(),      "-o",
                                      run_file,         "--progress", line_.extras.progress};
    if (std::filesystem::exists(run_file)) words.emplace_back("--resume");
    if (step > 0) words.insert(words.end(), {"--set", fmt::format("optimizer.stop.iterations={}", step)});
    if (line_.extras.threads > 0) words.insert(words.end(), {"--threads", std::to_string(line_.extras.threads)});
    if (line_.extras.quiet) words.emplace_back("--quiet");
    const ChildResult result = run_child(words, std::numeric_limits<double>::infinity(), signals_);
    return result.end == ChildResult::End::exited ? result.status : exit_stopped_line;
  }
  std::vector<std::string> export_images(std::int64_t step) const {
    if (line_.images.format == "csv") {
      std::vector<std::string> files = published_files(line_, step);
      write_csv(files_.run_file(step), files, line_.images.overwrite, posix_file_ops());
      return files;
    }
    return export_run_file(files_.run_file(step), images_of_step(line_, step), posix_file_ops()).files;
  }

 private:
  const PublishedLine& line_;
  const LineFiles& files_;
  StopSignals signals_;
};

// R at the end of the run; negative where the method has none.
double relative_error_of(const std::string& run_file) {
  const RunFileReader reader = open_to_look_at(run_file);
  const auto found = reader.content().state.find("relative_error");
  if (found == reader.content().state.end()) return -1;
  const double* const value = std::get_if<double>(&found->second);
  return value != nullptr ? *value : -1;
}

void print_result_of_line(const PublishedLine& line, const std::vector<std::string>& files, double relative_error) {
  if (line.extras.json) {
    std::string list;
    for (const std::string& file : files) list += (list.empty() ? "" : ", ") + json_string(file);
    std::string notes;
    for (const std::string& note : line.notes) notes += (notes.empty() ? "" : ", ") + json_string(note);
    const std::string error = relative_error < 0 ? "null" : json_number(relative_error);
    fmt::print("{{\"files\": [{}], \"relative_error\": {}, \"seed\": {}, \"config\": {}, \"notes\": [{}]}}\n", list,
               error, line.seed, json_string(line.config), notes);
    return;
  }
  for (const std::string& note : line.notes) fmt::print("note: {}\n", note);
  fmt::print("wrote {}\n", list_of_files(files));
  if (relative_error >= 0) fmt::print("R = {:.4f}   (white noise: 1)\n", relative_error);
  fmt::print("seed {}{}\n", line.seed, line.seed_is_drawn ? ", drawn: give it as -seed to make the same again" : "");
}

std::vector<std::string> all_files(const PublishedLine& line) {
  std::vector<std::string> files = published_files(line, 0);
  for (const std::int64_t step : line.steps) {
    const std::vector<std::string> more = published_files(line, step);
    files.insert(files.end(), more.begin(), more.end());
  }
  return files;
}

int make_line(PublishedLine& line) {
  OutputFiles(posix_file_ops(), line.extras.overwrite).check(all_files(line));
  const LineFiles files(line);
  if (const auto folder = std::filesystem::path(line.stem).parent_path(); !folder.empty())
    std::filesystem::create_directories(folder);
  // Held until the images are there: nobody else may replace the config in between.
  const RunLock lock(files.config(), [](const std::string& text) { print_error(text + "\n"); });
  go_on_from_stopped(line, files);
  OutputFiles config(posix_file_ops(), true);
  config.write(files.config(), commented_config(line));
  config.commit();
  for (const PublishedInput& input : line.inputs) write_npy(input.path, input.shape, input.values());
  LineRunner runner(line, files);
  std::vector<std::int64_t> steps = line.steps;
  steps.push_back(0);
  for (const std::int64_t step : steps) {
    const int status = runner.make(step);
    if (status == exit_stopped_line && !line.extras.quiet)
      print_error("stopped, with everything saved: the same line goes on\n");
    if (status == 0) continue;
    if (!files.has_run_file()) files.remove();  // nothing to go on from
    return status;
  }
  std::vector<std::string> made;
  for (const std::int64_t step : steps) {
    const std::vector<std::string> images = runner.export_images(step);
    made.insert(made.end(), images.begin(), images.end());
  }
  const double relative_error = relative_error_of(files.run_file(0));
  files.remove();
  if (!line.extras.quiet) print_result_of_line(line, made, relative_error);
  return 0;
}

}  // namespace

namespace {

PublishedLine line_of(const PublishedProgram& program, const std::vector<std::string>& words) {
  try {
    return program.read(words);
  } catch (const UserError& error) {
    std::vector<Fault> faults = error.faults();
    if (faults.back().where == "command line")
      faults.back().text += fmt::format("; see noiseloom {} --help", program.name);
    throw UserError(std::move(faults));
  }
}

}  // namespace

int run_published(const std::string& command, const std::vector<std::string>& words) {
  const PublishedProgram& program = *find_published_program(command);
  PublishedLine line = line_of(program, words);
  if (line.extras.help) {
    fmt::print("{}", program.help);
    return 0;
  }
  parse_config(line.config, "the config that the line means", "", {}, MissingFiles::accepted);
  if (line.extras.print_config) {
    fmt::print("{}", commented_config(line));
    return 0;
  }
  return make_line(line);
}

}  // namespace noiseloom
