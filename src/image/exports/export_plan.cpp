#include "image/exports/export_planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>

#include "noiseloom/files/pixel_order.h"
#include "noiseloom/image/consumers.h"
#include "noiseloom/image/sequence.h"

namespace noiseloom {
namespace {

std::vector<std::string> all_container_names() {
  std::vector<std::string> names;
  for (const Container& container : containers()) names.push_back(container.name);
  return names;
}

}  // namespace

ExportPlanner::Output ExportPlanner::split_output(const std::string& output) {
  namespace fs = std::filesystem;
  const fs::path path(output);
  if (output.ends_with("/") || fs::is_directory(path) || (path.extension().empty() && !is_sequence_pattern(output)))
    return {path, ""};
  return {path.parent_path(), path.filename().string()};
}

ExportPlanner::ExportPlanner(const std::string& name, const RunFileContent& content, const ProblemSpec& problem,
                             const ExportOptions& options)
    : name_(name), content_(content), problem_(problem), options_(options) {}

void ExportPlanner::take_consumer() {
  if (options_.consumer.empty()) return;
  options_ = for_consumer(options_, problem_, channels(), std::filesystem::path(name_).stem().string(),
                          why_order_cannot_be_read(content_).empty(), faults_);
  throw_if_any(faults_);
}

ExportPlan ExportPlanner::plan() {
  take_consumer();
  output_ = split_output(options_.output);
  choose_container();
  if (container_ == nullptr) throw_if_any(faults_);
  main_.container = container_;
  choose_type();
  choose_layout();
  choose_frames();
  choose_slices();
  choose_columns();
  choose_points();
  choose_naming();
  if (container_->content == ContainerContent::pixels) {
    choose_pixel();
    choose_range();
  }
  throw_if_any(faults_);
  choose_targets();
  throw_if_any(faults_);
  return std::move(plan_);
}

void ExportPlanner::choose_container() {
  if (options_.output == "-") {
    fault("-o -: an export is one or more files, which cannot go to standard output; give a file or a folder");
    return;
  }
  const std::string ending = std::filesystem::path(output_.file).extension().string();
  const Container* const by_ending = ending.empty() ? nullptr : container_of_file(output_.file);
  if (!ending.empty() && by_ending == nullptr && options_.consumer.empty()) {
    fault(fmt::format("-o {}: \"{}\" is no ending of a container that is written; accepted: {} (a folder ends in /)",
                      options_.output, ending, container_names()));
    return;
  }
  if (options_.format.empty()) {
    container_ = by_ending != nullptr ? by_ending : &containers().front();
  } else {
    container_ = find_container(options_.format, ContainerContent::pixels);
    if (container_ == nullptr) container_ = find_container(options_.format, ContainerContent::places);
    if (container_ == nullptr) {
      const std::string nearest = nearest_word(options_.format, all_container_names());
      fault(fmt::format("--format {}: not written{}; accepted: {}", options_.format,
                        nearest.empty() ? "" : fmt::format("; did you mean \"{}\"?", nearest), container_names()));
    } else if (by_ending != nullptr && by_ending != container_ && options_.consumer.empty()) {
      fault(fmt::format("--format {}, but -o {} ends in {}", container_->name, options_.output, ending));
    }
  }
  if (container_ != nullptr && container_->content == ContainerContent::places && !points_wanted())
    fault(
        fmt::format("{} holds the coordinates of a point set: give its density with --threshold; accepted for the "
                    "values of a texture: {}",
                    container_->name, names_of_containers([](const Container&) { return true; })));
}

void ExportPlanner::choose_type() {
  if (container_->types.empty()) {
    if (!options_.depth.empty()) fault(fmt::format("--depth {}: {} holds no pixels", options_.depth, container_->name));
    return;
  }
  main_.type = container_->types.front();
  if (options_.depth.empty()) return;
  std::vector<std::string> accepted;
  for (const PixelType type : container_->types) {
    accepted.push_back(depth_name(type));
    if (accepted.back() != options_.depth) continue;
    main_.type = type;
    return;
  }
  fault(fmt::format("--depth {0}: {1} does not hold it; accepted for {1}: {2}", options_.depth, container_->name,
                    fmt::join(accepted, ", ")));
}

void ExportPlanner::choose_layout() {
  main_.layout = container_->layouts.front();
  if (options_.layout.empty()) return;
  std::vector<std::string> accepted;
  const std::string word = options_.layout.substr(0, options_.layout.find(':'));
  for (const ExportLayout layout : container_->layouts) {
    accepted.push_back(to_string(layout));
    if (accepted.back() != word || (word != options_.layout && layout != ExportLayout::atlas)) continue;
    main_.layout = layout;
    return;
  }
  fault(accepted.size() == 1 ? fmt::format("--layout {}: {} always holds the whole {}", options_.layout,
                                           container_->name, accepted.front())
                             : fmt::format("--layout {}: accepted for {}: {}", options_.layout, container_->name,
                                           fmt::join(accepted, ", ")));
}

// How many slices stand beside each other: of an atlas the columns given (atlas:CxR), else the fewest that divide the
// slices and are at least as many as the rows.
void ExportPlanner::choose_columns() {
  const std::int32_t slices = plan_.end - plan_.begin;
  if (main_.layout == ExportLayout::row) main_.columns = slices;
  if (main_.layout != ExportLayout::atlas) return;
  const std::size_t colon = options_.layout.find(':');
  if (colon == std::string::npos) {
    main_.columns = std::max(1, static_cast<int>(std::ceil(std::sqrt(slices))));
    while (slices % main_.columns != 0) ++main_.columns;
    return;
  }
  int rows = 0;
  const char* const first = options_.layout.data() + colon + 1;
  const char* const last = options_.layout.data() + options_.layout.size();
  const auto [times, error] = std::from_chars(first, last, main_.columns);
  const auto [end, row_error] =
      times < last ? std::from_chars(times + 1, last, rows) : std::from_chars_result{last, std::errc::invalid_argument};
  const bool sound = error == std::errc{} && row_error == std::errc{} && *times == 'x' && end == last;
  if (!sound || main_.columns < 1 || rows < 1)
    fault(fmt::format("--layout {}: accepted: atlas, or atlas:CxR for C columns and R rows", options_.layout));
  else if (std::int64_t{main_.columns} * rows < slices || std::int64_t{main_.columns} * (rows - 1) >= slices)
    fault(fmt::format("--layout {}: {} slices take {} rows of {}", options_.layout, slices,
                      (slices + main_.columns - 1) / main_.columns, main_.columns));
}

ExportPlan plan_export(const std::string& name, const RunFileContent& content, const ProblemSpec& problem,
                       const ExportOptions& options) {
  return ExportPlanner(name, content, problem, options).plan();
}

}  // namespace noiseloom
