// The table of all built-in spaces.
#include "samples/spaces.h"

#include <algorithm>
#include <vector>

#include "noiseloom/core/error.h"
#include "samples/space_image.h"

namespace noiseloom {
namespace {

std::vector<SpacePtr> make_spaces() {
  std::vector<SpacePtr> spaces;
  spaces.push_back(uniform_space());
  spaces.push_back(tent_space());
  spaces.push_back(gauss_space());
  spaces.push_back(circle_space());
  for (int channels = 2; channels <= 8; ++channels) spaces.push_back(cube_space(channels));
  spaces.push_back(sphere_space());
  spaces.push_back(hemisphere_space());
  spaces.push_back(hemisphere_cosine_space());
  spaces.push_back(disk_space());
  return spaces;
}

}  // namespace

std::span<const SampleSpace* const> sample_spaces() {
  static const std::vector<SpacePtr> owned = make_spaces();
  static const std::vector<const SampleSpace*> spaces = [] {
    std::vector<const SampleSpace*> pointers;
    for (const SpacePtr& space : owned) pointers.push_back(space.get());
    return pointers;
  }();
  return spaces;
}

const SampleSpace* find_sample_space(std::string_view name) {
  const auto spaces = sample_spaces();
  const auto found = std::find_if(spaces.begin(), spaces.end(),
                                  [&](const SampleSpace* space) { return space->traits().name == name; });
  return found == spaces.end() ? nullptr : *found;
}

const SampleSpace& sample_space(const SampleSpec& spec) {
  const SampleSpace* const space = find_sample_space(spec.space);
  NOISELOOM_CHECK(space != nullptr);
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
