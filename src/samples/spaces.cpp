// The table of all built-in spaces.
#include "samples/spaces.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include "noiseloom/core/error.h"
#include "samples/space_image.h"

namespace noiseloom {
namespace {

// A space without parameters, or a family and its member of the initial parameters.
struct Row {
  explicit Row(SpacePtr only) : space(std::move(only)) {}
  explicit Row(SpaceFamily all)
      : family(std::move(all)), space(family.make(family.traits, initial_parameters(family.traits))) {}

  SpaceFamily family{};
  SpacePtr space;
};

std::vector<Row> make_rows() {
  std::vector<Row> rows;
  rows.emplace_back(uniform_space());
  rows.emplace_back(tent_space());
  rows.emplace_back(gauss_space());
  rows.emplace_back(exponential_space());
  rows.emplace_back(circle_space());
  for (int channels = 2; channels <= 8; ++channels) rows.emplace_back(cube_space(channels));
  rows.emplace_back(sphere_space());
  rows.emplace_back(hemisphere_space());
  rows.emplace_back(hemisphere_cosine_space());
  rows.emplace_back(cone_family());
  rows.emplace_back(ggx_family());
  rows.emplace_back(axis_space());
  rows.emplace_back(rotation_space());
  rows.emplace_back(disk_space());
  rows.emplace_back(ring_family());
  rows.emplace_back(hexagon_space());
  rows.emplace_back(star_family());
  rows.emplace_back(gauss2_space());
  rows.emplace_back(triangle_space());
  rows.emplace_back(sobol_family());
  return rows;
}

const std::vector<Row>& all_rows() {
  static const std::vector<Row> rows = make_rows();
  return rows;
}

const Row* find_row(std::string_view name) {
  const auto found = std::find_if(all_rows().begin(), all_rows().end(),
                                  [&](const Row& row) { return row.space->traits().name == name; });
  return found == all_rows().end() ? nullptr : &*found;
}

}  // namespace

std::span<const SampleSpace* const> sample_spaces() {
  static const std::vector<const SampleSpace*> spaces = [] {
    std::vector<const SampleSpace*> pointers;
    for (const Row& row : all_rows()) pointers.push_back(row.space.get());
    return pointers;
  }();
  return spaces;
}

const SampleSpace* find_sample_space(std::string_view name) {
  const Row* const row = find_row(name);
  return row == nullptr ? nullptr : row->space.get();
}

std::vector<double> initial_parameters(const SpaceTraits& traits) {
  std::vector<double> values;
  for (const SpaceParameter& parameter : traits.parameters) values.push_back(parameter.initial);
  return values;
}

// A process meets a few sets of parameters at most, so that what was made is kept.
const SampleSpace& sample_space(const SampleSpec& spec) {
  const Row* const row = find_row(spec.space);
  NOISELOOM_CHECK(row != nullptr);
  const SpaceTraits& traits = row->space->traits();
  if (spec.parameters.empty() || spec.parameters == initial_parameters(traits)) return *row->space;
  NOISELOOM_CHECK_EQ(spec.parameters.size(), traits.parameters.size());
  static std::mutex mutex;
  static std::map<std::pair<std::string, std::vector<double>>, SpacePtr> made;
  const std::lock_guard lock(mutex);
  SpacePtr& space = made[{spec.space, spec.parameters}];
  if (!space) space = row->family.make(row->family.traits, spec.parameters);
  return *space;
}

std::shared_ptr<const SampleSpace> space_of(const SampleSpec& spec) {
  if (spec.is_image()) return shared_image_space(spec);
  return {std::shared_ptr<void>(), &sample_space(spec)};  // the table owns it
}

SpaceTraits space_traits(const SampleSpec& spec) {
  return spec.is_image() ? image_space_traits(spec.onto) : sample_space(spec).traits();
}

}  // namespace noiseloom
