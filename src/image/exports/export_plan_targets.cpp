#include "image/exports/export_planner.h"

#include <fmt/format.h>

#include <algorithm>

#include "noiseloom/files/pixel_order.h"
#include "noiseloom/image/sequence.h"

namespace noiseloom {

namespace fs = std::filesystem;

void ExportPlanner::choose_naming() {
  pattern_in_output_ = !output_.file.empty() && is_sequence_pattern(output_.file);
  if (pattern_in_output_ && !options_.naming.empty())
    fault(fmt::format("-o {} is a pattern already; leave --naming out", options_.output));
  const std::string text = pattern_in_output_ ? output_.file : options_.naming.empty() ? "plain" : options_.naming;
  naming_ = parsed([&] { return parse_naming(text); });
  for (const std::string& part : {output_.folder.string(), pattern_in_output_ ? std::string() : output_.file})
    if (const std::string why = why_no_file_name(part); !why.empty())
      fault(fmt::format("-o {}: {}", options_.output, why));
  if (output_.file.empty() || pattern_in_output_) return;
  if (naming_.scheme != NamingScheme::plain)
    fault(
        fmt::format("--naming {} names the files itself: give a folder, not -o {}", options_.naming, options_.output));
}

std::string ExportPlanner::target(const std::string& file) const { return (output_.folder / file).string(); }

void ExportPlanner::choose_targets() {
  name_main_output();
  plan_.outputs.push_back(main_);
  if (options_.density == "separate") add_density_images();
  if (plan_.num_points) add_point_tables();
}

void ExportPlanner::name_main_output() {
  const std::int32_t count = plan_.extents.num_slices();
  const bool one_file = main_.layout != ExportLayout::slices;
  const bool own_name = !output_.file.empty() && !pattern_in_output_;
  if (own_name && (one_file || count == 1)) {
    main_.targets = {target(output_.file)};
    return;
  }
  std::string ending = fs::path(output_.file).extension().string();
  if (ending.empty()) ending = container_->endings.front();
  std::string stem = fs::path(name_).stem().string();
  if (own_name) {
    stem = fs::path(output_.file).stem().string();
  } else {
    stem = texture_name(naming_, problem_, stem, why_order_cannot_be_read(content_).empty());
    if (plan_.num_points) stem += "_below" + density_;
  }
  if (one_file) {
    if (naming_.scheme == NamingScheme::pattern)
      fault(
          fmt::format("{}: numbers slices, but {} with layout {} is one file; leave the number out, or choose another "
                      "--layout or --format",
                      pattern_in_output_ ? "-o " + options_.output : "--naming " + options_.naming, container_->name,
                      to_string(main_.layout)));
    main_.targets = {container_->content == ContainerContent::places ? target(table_stem() + ending)
                                                                     : target(stem + ending)};
    return;
  }
  for (const SliceIndex s : plan_.slices())
    main_.targets.push_back(target(slice_file_name(naming_, stem, s.value(), count, ending)));
}

// Beside each file of samples one of their densities, in one channel as the container holds scalars.
void ExportPlanner::add_density_images() {
  ExportOutput beside = main_;
  beside.pixel = container_->pixel(1, false);
  std::replace(beside.pixel.source.begin(), beside.pixel.source.end(), 0, density_channel);
  for (std::string& file : beside.targets) {
    const fs::path path(file);
    file = (path.parent_path() / (path.stem().string() + "_pdf" + path.extension().string())).string();
  }
  plan_.outputs.push_back(beside);
}

// Of a table in a folder, where several point sets may lie; beside a file with a name of its own, after that.
std::string ExportPlanner::table_stem() const {
  if (output_.file.empty() || pattern_in_output_) return "points_below" + density_;
  return fs::path(output_.file).stem().string() + "_points";
}

// The coordinates as text always, and in the container of the images, where that has a table too.
void ExportPlanner::add_point_tables() {
  for (const Container& container : containers()) {
    if (container.content != ContainerContent::places || &container == container_) continue;
    if (container_->content == ContainerContent::places) continue;
    if (container.name != "csv" && container.name != container_->name) continue;
    ExportOutput table;
    table.container = &container;
    table.layout = container.layouts.front();
    table.targets = {target(table_stem() + container.endings.front())};
    plan_.outputs.push_back(table);
  }
}

}  // namespace noiseloom
