// What the checkpoints of all methods share: fields named once for storing, loading and telling the other ranks, and
// the publication of a run file whose slices come from all ranks.
//
// A `visit` is a generic function visit(object, f) that calls f(name, field) for every field of the object.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "noiseloom/config/config.h"
#include "noiseloom/dist/communicator.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {

inline const char* const samples_name = "/samples";

// With the state and history of a run. Fields are integers of 64 bits, double or text; those of a row double.
template <class State, class VisitState, class VisitRow>
RunFileContent content_of(const RunConfig& config, const State& state, const VisitState& visit_state,
                          const VisitRow& visit_row, const std::string& inputs,
                          const std::map<std::string, Attribute>& provenance) {
  RunFileContent content;
  content.extents = config.problem.extents;
  content.config = to_toml(config);
  visit_state(state, [&](const char* name, const auto& value) { content.state[name] = value; });
  content.state["inputs"] = inputs;
  using Row = typename decltype(state.history)::value_type;
  visit_row(Row{}, [&](const char* name, double) { content.history.push_back({name, {}}); });
  for (const Row& row : state.history) {
    std::size_t column = 0;
    visit_row(row, [&](const char*, double value) { content.history[column++].second.push_back(value); });
  }
  content.provenance = provenance;
  return content;
}

// The other way. Throws UserError for a file that lacks a field.
template <class State, class VisitState, class VisitRow>
State state_of(const RunFileContent& content, const VisitState& visit_state, const VisitRow& visit_row) {
  State state;
  visit_state(state, [&](const char* name, auto& value) {
    const auto found = content.state.find(name);
    using Value = std::decay_t<decltype(value)>;
    if (found == content.state.end() || !std::holds_alternative<Value>(found->second)) {
      throw UserError("", fmt::format("/state has no usable attribute \"{}\"; not written by generate", name));
    }
    value = std::get<Value>(found->second);
  });
  for (const auto& stored : content.history) {
    const std::string& column = stored.first;  // no binding, which clang 14 cannot capture
    const std::vector<double>& values = stored.second;
    state.history.resize(values.size());
    for (std::size_t row = 0; row < values.size(); ++row) {
      visit_row(state.history[row], [&](const char* name, double& value) {
        if (column == name) value = values[row];
      });
    }
  }
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
                        const Partition& partition, const Communicator& communicator, const ProduceSlice& produce);

template <class T>
void append(std::vector<std::byte>& block, const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  block.insert(block.end(), bytes.begin(), bytes.end());
}

}  // namespace noiseloom
