// What the checkpoints of all methods share: fields named once for storing, loading and telling the other ranks, the
// checks of what comes back, and the publication of a run file whose slices come from all ranks.
//
// Right digests say that a file holds what was written, not that it makes sense: another program may have written it,
// or a person. So every number is checked before it is used.
//
// A `visit` is a generic function visit(object, f) that calls f(name, field) for every field of the object.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/config/inputs.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

inline const char* const samples_name = "/samples";
inline const char* const permutation_name = "/state/permutation";
inline const char* const given_name = "/state/given";
inline const char* const pdf_name = "/pdf";

// Of a run whose samples are placed: by swaps, or by construction.
std::vector<SliceDataset> datasets_for(int channels, bool has_pdf, bool has_given = false);

// Whether swaps begin with what was constructed or what a file holds, which the run file keeps; else at random.
bool begins_with_arrangement(const RunConfig& config);
// The number of the algorithm that this program has for a method (anneal/swap_optimizer.h,
// construct/void_and_cluster.h).
std::int64_t algorithm_of(Method method);
// Throws UserError, saying what to do, for a run that another algorithm has begun.
void require_same_algorithm(const RunFileContent& content, Method method, const std::string& path);

// Collects what is wrong with the contents of one run file.
class ContentFaults {
 public:
  explicit ContentFaults(std::string path) : path_(std::move(path)) {}
  // `text` says what was found and what can be: "/state/@step = 1000: ...". Only the first few are kept.
  void require(bool sound, const std::string& text) {
    if (!sound && faults_.size() < most_) faults_.push_back({path_, text});
  }
  bool any() const { return !faults_.empty(); }
  void throw_if_any();

 private:
  static constexpr std::size_t most_ = 10;
  std::string path_;
  std::vector<Fault> faults_;
};

// That the file has these datasets, of these types.
void check_datasets(const RunFileContent& content, const std::vector<SliceDataset>& expected, ContentFaults& faults);
// Whole, at least `least`, not more than `most` and exact: what a double of /history must be where it counts something.
bool is_count(double value, double least, double most);
// A number that is not below zero: neither NaN nor infinite.
bool is_finite_positive_or_zero(double value);
// Fault of a slice of /state/permutation: "" where it holds each of 0 .. size - 1 once.
std::string permutation_fault(std::span<const SampleId> ids);

// With the state and history of a run, or of the part of one that goes by `method`. Fields are integers of 64 bits,
// double or text; those of a row double.
template <class State, class VisitState, class VisitRow>
RunFileContent content_of(const RunConfig& config, Method method, const State& state, const VisitState& visit_state,
                          const VisitRow& visit_row, const std::map<std::string, Attribute>& provenance) {
  RunFileContent content;
  content.extents = config.problem.extents;
  content.config = to_toml(config);
  visit_state(state, [&](const char* name, const auto& value) { content.state[name] = value; });
  content.state["algorithm"] = algorithm_of(method);
  content.inputs = inputs_of(config);
  using Row = typename decltype(state.history)::value_type;
  visit_row(Row{}, [&](const char* name, double) { content.history.push_back({name, {}}); });
  for (const Row& row : state.history) {
    std::size_t column = 0;
    visit_row(row, [&](const char*, double value) { content.history[column++].second.push_back(value); });
  }
  content.provenance = provenance;
  return content;
}

// The other way. Throws UserError, with the path, for a file that lacks a field or a column.
template <class State, class VisitState, class VisitRow>
State state_of(const RunFileContent& content, const std::string& path, const VisitState& visit_state,
               const VisitRow& visit_row) {
  State state;
  ContentFaults faults(path);
  visit_state(state, [&](const char* name, auto& value) {
    const auto found = content.state.find(name);
    using Value = std::decay_t<decltype(value)>;
    const bool usable = found != content.state.end() && std::holds_alternative<Value>(found->second);
    faults.require(usable, fmt::format("/state has no usable attribute \"{}\"", name));
    if (usable) value = std::get<Value>(found->second);
  });
  using Row = typename decltype(state.history)::value_type;
  const std::size_t rows = content.history.empty() ? 0 : content.history.front().second.size();
  state.history.resize(rows);
  faults.require(rows > 0, "/history has no rows; a run has one from its start on");
  visit_row(Row{}, [&](const char* name, double) {
    const auto column = std::find_if(content.history.begin(), content.history.end(),
                                     [&](const auto& stored) { return stored.first == name; });
    if (column == content.history.end()) return faults.require(false, fmt::format("/history/{}: missing", name));
    const std::vector<double>& values = column->second;
    if (values.size() != rows) {
      return faults.require(false, fmt::format("/history/{}: {} rows, but /history/{} has {}", name, values.size(),
                                               content.history.front().first, rows));
    }
    for (std::size_t row = 0; row < rows; ++row) {
      visit_row(state.history[row], [&](const char* field, double& value) {
        if (std::strcmp(field, name) == 0) value = values[row];
      });
    }
  });
  faults.throw_if_any();
  return state;
}

// The state of rank 0 on every rank. *Collective*
template <class State, class VisitState>
void broadcast_state(State& state, const VisitState& visit_state, const Communicator& communicator) {
  std::string bytes;
  const auto put = [&bytes](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); };
  std::size_t at = 0;
  const auto get = [&](void* data, std::size_t size) {
    NOISELOOM_CHECK_LE(at + size, bytes.size());
    if (size > 0) std::memcpy(data, bytes.data() + at, size);
    at += size;
  };
  using Row = typename decltype(state.history)::value_type;
  static_assert(std::is_trivially_copyable_v<Row>);
  std::uint64_t rows = state.history.size();
  put(&rows, sizeof(rows));
  if (rows > 0) put(state.history.data(), rows * sizeof(Row));
  visit_state(state, [&](const char*, const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::string>) {
      const std::uint64_t length = value.size();
      put(&length, sizeof(length));
      put(value.data(), length);
    } else {
      put(&value, sizeof(value));
    }
  });
  communicator.broadcast(bytes);
  get(&rows, sizeof(rows));
  state.history.resize(rows);
  get(state.history.data(), rows * sizeof(Row));
  visit_state(state, [&](const char*, auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, std::string>) {
      std::uint64_t length = 0;
      get(&length, sizeof(length));
      value.resize(length);
      get(value.data(), length);
    } else {
      get(&value, sizeof(value));
    }
  });
}

// Fills `block` with the bytes of an own slice of content.datasets[dataset].
using ProduceSlice = std::function<void(std::size_t dataset, SliceIndex slice, std::vector<std::byte>& block)>;

// Publishes at `path`, one dataset after the other, so that no rank holds more than one of a slice's at once: a slice
// may be the whole texture. Returns the combined checksum of the first dataset on rank 0. *Collective*
std::string publish_run(FileOps& ops, const std::string& path, const RunFileContent& content,
                        const Distribution& distribution, const Communicator& communicator,
                        const ProduceSlice& produce);

template <class T>
void append(std::vector<std::byte>& block, const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  block.insert(block.end(), bytes.begin(), bytes.end());
}

}  // namespace noiseloom
