// The passes of a rendering: what each needs and makes, and which of them a scene calls for.
//
// A table lists the passes in the order in which they run. What is asked for is wanted; walking the table backwards, a
// pass is on where it makes something that is wanted and applies to the scene, and what it needs is then wanted too.
// Nothing else is built, allocated or run: data has one maker, and is absent where that is off.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "noiseloom/render/noise.h"
#include "noiseloom/render/scene.h"

namespace noiseloom::render {

// What passes hand to each other in memory.
enum class Data : std::uint8_t {
  noises,
  picture,
  density,
  light,
  columns,
  flights,
  mesh,
  shares,
  hits,
  moving_hits,
  edge_weights,
  kernel,
  importance,
  sky,
  sky_truths,
  carrying,
  seeds,
  truth,
  estimate,
  accumulated,
  filtered,
  seen,
  errors,
  stacks,
  pictures,
  predictions
};
inline constexpr int num_data = 26;
std::string_view name_of(Data data);

class DataSet {
 public:
  constexpr DataSet() = default;
  constexpr DataSet(std::initializer_list<Data> data) {
    for (const Data one : data) bits_ |= bit(one);
  }
  constexpr bool has(Data data) const { return (bits_ & bit(data)) != 0; }
  constexpr bool meets(DataSet other) const { return (bits_ & other.bits_) != 0; }
  constexpr void add(DataSet other) { bits_ |= other.bits_; }
  constexpr void flip(Data data) { bits_ ^= bit(data); }

 private:
  static constexpr std::uint32_t bit(Data data) { return 1U << static_cast<unsigned>(data); }
  std::uint32_t bits_ = 0;
};

// What is counted while passes run. Each worker counts for itself.
enum class Work : std::uint8_t {
  expectations,
  texture_values,   // of noises that are textures
  computed_values,  // of noises that are computed
  estimates,
  primary_rays,
  rays,
  mesh_rays,
  march_steps,
  density_reads,
  averages,
  history_reads,
  taps,
  guided_taps,  // of filters that weigh each tap anew
  differences,
  transformed_values,  // by Fourier transforms
  moved_seeds,
  ranks,     // of pixels among their neighbours
  exchanges  // tried between cells of masks
};
inline constexpr int num_work = 18;
std::string_view name_of(Work work);
using Counts = std::array<std::int64_t, num_work>;
constexpr std::int64_t& count_of(Counts& counts, Work work) { return counts[static_cast<std::size_t>(work)]; }
constexpr std::int64_t count_of(const Counts& counts, Work work) { return counts[static_cast<std::size_t>(work)]; }

// Data that its pass makes, and nobody else: absent where that pass is off.
template <class T>
class Made {
 public:
  bool is_there() const { return value_ != nullptr; }
  T& make(T value = {}) {
    value_ = std::make_unique<T>(std::move(value));
    return *value_;
  }
  // Throws std::logic_error, naming both, where it was not made.
  const T& get(Data data, std::string_view reader) const {
    if (value_ == nullptr)
      throw std::logic_error("the pass " + std::string(reader) + " reads the data " + std::string(name_of(data)) +
                             ", which no pass has made");
    return *value_;
  }
  T& get(Data data, std::string_view reader) {
    return const_cast<T&>(static_cast<const Made&>(*this).get(data, reader));
  }

 private:
  std::unique_ptr<T> value_;
};

struct Shared;
struct Job;

struct Pass {
  std::string_view name;
  DataSet needs;
  DataSet makes;
  // Why it does not apply to the scene; empty where it does.
  std::string (*off)(const Scene&);
  // One of the two: run once before all frames, or in every frame of every job (one noise, one effect, one repeat).
  void (*prepare)(Shared&) = nullptr;
  void (*frame)(Job&) = nullptr;
  // Of all its calls together. Noises may be described only (without their textures).
  Counts (*work)(const Scene&, std::span<const Noise>) = nullptr;
  std::int64_t (*bytes)(const Scene&, std::span<const Noise>) = nullptr;  // that its data takes, in all workers: each
};

// All of them.
std::span<const Pass> all_passes();

struct PlannedPass {
  const Pass* pass;
  bool on = false;
  std::string why;  // "for the table of results", "off: no filter over time"
  std::int64_t calls = 0;
  Counts work{};
  std::int64_t bytes = 0;
};

// Which passes the scene calls for. Pure.
std::vector<PlannedPass> plan_passes(std::span<const Pass> passes, const Scene& scene, std::span<const Noise> noises);

// Seconds of one processor that the pass is expected to take.
double predicted_seconds(const PlannedPass& planned);

}  // namespace noiseloom::render
