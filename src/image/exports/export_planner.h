// How the options of an export become a plan (export.h): one function for each thing that is chosen, in the order of
// plan(). Faults are collected, so that a user sees all of them at once.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "noiseloom/core/error.h"
#include "noiseloom/image/export.h"
#include "noiseloom/image/naming.h"

namespace noiseloom {

class ExportPlanner {
 public:
  ExportPlanner(const std::string& name, const RunFileContent& content, const ProblemSpec& problem,
                const ExportOptions& options);
  ExportPlan plan();

 private:
  void take_consumer();
  // What the numbers are written in (export_plan.cpp).
  void choose_container();
  void choose_type();
  void choose_layout();
  void choose_columns();
  // Which of the samples (export_plan_slices.cpp).
  void choose_frames();
  void choose_slices();
  void choose_points();
  std::int32_t count_of(const std::string& option, const std::string& text, std::int32_t most);
  // What a pixel holds (export_plan_pixels.cpp).
  int channels() const;
  void choose_pixel();
  void choose_pixel_size();
  void choose_range();
  // Where it goes (export_plan_targets.cpp).
  void choose_naming();
  void choose_targets();
  void name_main_output();
  void add_density_images();
  void add_point_tables();
  std::string table_stem() const;
  std::string target(const std::string& file) const;

  void fault(const std::string& text) { faults_.push_back({"command line", text}); }
  template <class Parse>
  auto parsed(Parse parse) -> decltype(parse()) {
    try {
      return parse();
    } catch (const UserError& error) {
      faults_.insert(faults_.end(), error.faults().begin(), error.faults().end());
      return {};
    }
  }
  bool points_wanted() const { return !options_.threshold.empty(); }
  bool density_wanted() const { return options_.density == "alpha" || options_.density == "separate"; }

  // Where the files go: a file (or pattern of files) in a folder, or a folder alone.
  struct Output {
    std::filesystem::path folder;
    std::string file;  // "": a folder was given
  };
  static Output split_output(const std::string& output);

  const std::string& name_;
  const RunFileContent& content_;
  const ProblemSpec& problem_;
  ExportOptions options_;  // with what a consumer decides
  Output output_;
  bool pattern_in_output_ = false;
  Naming naming_;
  std::string density_;  // in digits, for names
  const Container* container_ = nullptr;
  ExportOutput main_;
  ExportPlan plan_;
  std::vector<Fault> faults_;
};

// The names of the containers for pixels that `accept` takes, for messages.
template <class Accept>
std::string names_of_containers(Accept accept) {
  std::string names;
  for (const Container& container : containers())
    if (container.content == ContainerContent::pixels && accept(container))
      names += (names.empty() ? "" : ", ") + container.name;
  return names;
}

}  // namespace noiseloom
