#include "render/jobs/retarget.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "noiseloom/core/error.h"
#include "noiseloom/core/random.h"
#include "render/jobs/frames.h"
#include "render/jobs/job.h"
#include "render/jobs/scene_passes.h"
#include "render/jobs/scene_sizes.h"
#include "render/jobs/seeds.h"

namespace noiseloom::render {
namespace {

constexpr int trials_of_cell = 64;

// From where in a mask to where in the next one: slices, and how far the latter is moved against the former.
struct Change {
  std::int64_t from = 0;
  std::int64_t to = 0;
  std::int64_t right = 0;
  std::int64_t down = 0;
  auto operator<=>(const Change&) const = default;
};

Change change_to(const Scene& scene, const Noise& target, int repeat, std::int64_t frame) {
  const MaskPlace before = mask_place(target, move_of_repeat(scene.seed, repeat), frame - 1);
  const MaskPlace now = mask_place(target, move_of_repeat(scene.seed, repeat), frame);
  const Extents& extents = target.extents;
  return {before.slice, now.slice, (now.x - before.x + extents.width()) % extents.width(),
          (now.y - before.y + extents.height()) % extents.height()};
}

// Those of all frames and repeats, each once, and which of them leads to a frame.
struct Changes {
  std::vector<Change> different;
  std::vector<std::size_t> which;  // [repeat * frames + frame - 1]
};

Changes changes_of(const Scene& scene, const Noise& target) {
  Changes changes;
  std::map<Change, std::size_t> known;
  for (int repeat = 0; repeat < scene.repeats; ++repeat)
    for (std::int64_t frame = 1; frame <= scene.frames; ++frame) {
      // Nothing leads beyond the last frame.
      const Change change = change_to(scene, target, repeat, std::min<std::int64_t>(frame, scene.frames - 1));
      const auto [found, is_new] = known.try_emplace(change, changes.different.size());
      if (is_new) changes.different.push_back(change);
      changes.which.push_back(found->second);
    }
  return changes;
}

bool is_carried(const NoiseSpec& spec) { return spec.kind == NoiseKind::heitz_belcour && spec.retarget > 0; }

// The first number of a slice, [y][x], moved to the left and upward.
std::vector<float> slice_of_mask(const Noise& target, std::int64_t slice, std::int64_t to_right, std::int64_t to_down) {
  NoiseReader reader(target, {.x = to_right, .y = to_down, .t = slice}, 1, static_cast<int>(target.extents.width()));
  std::vector<float> mask;
  for (int y = 0; y < target.extents.height(); ++y) {
    reader.read(y, 0);
    for (int x = 0; x < target.extents.width(); ++x) mask.push_back(reader.at(x)(0));
  }
  return mask;
}

// Calls with every noise that is carried, its target, and what its frames need.
template <class Body>
void for_each_carried(const Scene& scene, std::span<const Noise> noises, const Body& body) {
  for (std::size_t i = 0; i < noises.size(); ++i) {
    if (!is_carried(noises[i].spec) || scene.frames < 2) continue;
    const Noise& target = target_of(noises, noises[i].spec);
    body(i, target, changes_of(scene, target));
  }
}

}  // namespace

Carrying carrying_between(const std::vector<float>& from, const std::vector<float>& to, int width, int height,
                          int radius) {
  NOISELOOM_CHECK(radius >= 0 && radius <= 16);
  const auto cells = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  Carrying carrying{width, height, std::vector<Carrying::Step>(cells)};
  const auto wrapped = [](int place, int size) { return (place % size + size) % size; };
  const auto value_from = [&](int x, int y, Carrying::Step step) {
    return from[static_cast<std::size_t>(wrapped(y + step.dy, height)) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(wrapped(x + step.dx, width))];
  };
  const auto error = [](float a, float b) { return (a - b) * (a - b); };
  const auto choices = static_cast<std::uint64_t>(2 * radius + 1);
  for (int trial = 0; trial < trials_of_cell; ++trial)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const std::size_t cell =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
        const RandomBlock block = random_block(0, purpose_of_carrying, 0, static_cast<std::uint32_t>(trial), cell);
        const int to_right = static_cast<int>(to_below(block[0], choices)) - radius;
        const int to_down = static_cast<int>(to_below(block[1], choices)) - radius;
        const int other_x = wrapped(x + to_right, width);
        const int other_y = wrapped(y + to_down, height);
        const std::size_t other =
            static_cast<std::size_t>(other_y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(other_x);
        Carrying::Step& own = carrying.steps[cell];
        Carrying::Step& theirs = carrying.steps[other];
        const auto within = [&](int step) { return step >= -radius && step <= radius; };
        if (!within(theirs.dx + to_right) || !within(theirs.dy + to_down) || !within(own.dx - to_right) ||
            !within(own.dy - to_down)) {
          continue;
        }
        const float value = value_from(x, y, own);
        const float their_value = value_from(other_x, other_y, theirs);
        if (error(their_value, to[cell]) + error(value, to[other]) >=
            error(value, to[cell]) + error(their_value, to[other])) {
          continue;
        }
        const Carrying::Step swapped = {static_cast<std::int8_t>(theirs.dx + to_right),
                                        static_cast<std::int8_t>(theirs.dy + to_down)};
        theirs = {static_cast<std::int8_t>(own.dx - to_right), static_cast<std::int8_t>(own.dy - to_down)};
        own = swapped;
      }
  return carrying;
}

std::vector<std::size_t> Carrying::sources(int picture_width, int picture_height, std::int64_t left,
                                           std::int64_t top) const {
  const auto pixels = static_cast<std::size_t>(picture_width) * static_cast<std::size_t>(picture_height);
  std::vector<std::size_t> sources(pixels);
  std::vector<std::uint8_t> is_taken(pixels);
  std::vector<std::size_t> without;
  for (int y = 0; y < picture_height; ++y)
    for (int x = 0; x < picture_width; ++x) {
      const Step& step = steps[static_cast<std::size_t>((y + top) % height * width + (x + left) % width)];
      const std::size_t pixel =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(picture_width) + static_cast<std::size_t>(x);
      const int from_x = x + step.dx;
      const int from_y = y + step.dy;
      if (from_x < 0 || from_x >= picture_width || from_y < 0 || from_y >= picture_height) {
        without.push_back(pixel);
        continue;
      }
      const std::size_t source =
          static_cast<std::size_t>(from_y) * static_cast<std::size_t>(picture_width) + static_cast<std::size_t>(from_x);
      sources[pixel] = source;
      is_taken[source] = 1;
    }
  std::size_t left_over = 0;
  for (const std::size_t pixel : without) {
    while (is_taken[left_over] != 0) ++left_over;
    sources[pixel] = left_over++;
  }
  return sources;
}

void make_carrying(Shared& shared) {
  const std::vector<Noise>& noises = *shared.noises.get(Data::noises, shared.pass);
  CarryingOfFrames& all = shared.carrying.make();
  all.of_noise.resize(noises.size());
  all.which.resize(noises.size());
  for_each_carried(shared.scene, noises, [&](std::size_t i, const Noise& target, const Changes& changes) {
    std::vector<Carrying>& made = all.of_noise[i];
    made.resize(changes.different.size());
    all.which[i] = changes.which;
    shared.pool.for_each(std::ssize(made), [&](std::int64_t number, int) {
      const Change& change = changes.different[static_cast<std::size_t>(number)];
      made[static_cast<std::size_t>(number)] = carrying_between(
          slice_of_mask(target, change.from, 0, 0), slice_of_mask(target, change.to, change.right, change.down),
          static_cast<int>(target.extents.width()), static_cast<int>(target.extents.height()), noises[i].spec.retarget);
    });
    count_of(*shared.counts, Work::exchanges) += std::ssize(made) * target.extents.cells_per_slice() * trials_of_cell;
  });
}

std::string off_without_carrying(const Scene& scene) {
  return std::any_of(scene.noises.begin(), scene.noises.end(), is_carried)
             ? applies
             : "no noise of kind heitz-belcour with retarget";
}

Counts work_of_carrying(const Scene& scene, std::span<const Noise> noises) {
  Counts counts{};
  for_each_carried(scene, noises, [&](std::size_t, const Noise& target, const Changes& changes) {
    count_of(counts, Work::exchanges) +=
        std::ssize(changes.different) * target.extents.cells_per_slice() * trials_of_cell;
  });
  return counts;
}

std::int64_t bytes_of_carrying(const Scene& scene, std::span<const Noise> noises) {
  std::int64_t bytes = 0;
  for_each_carried(scene, noises, [&](std::size_t, const Noise& target, const Changes& changes) {
    bytes += std::ssize(changes.different) * target.extents.cells_per_slice() *
                 static_cast<std::int64_t>(sizeof(Carrying::Step)) +
             8 * std::ssize(changes.which);
  });
  return bytes;
}

}  // namespace noiseloom::render
