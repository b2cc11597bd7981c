#include "noiseloom/io/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "io/digest.h"

namespace noiseloom {
namespace {

const char* const samples_name = "/samples";
const char* const permutation_name = "/state/permutation";
const char* const pdf_name = "/pdf";

// Names each field of the saved state once, for storing and for loading.
template <class State, class Visit>
void visit_state(State& state, const Visit& visit) {
  visit("sweep", state.sweep);
  visit("step", state.step);
  visit("accepted", state.accepted);
  visit("candidates", state.candidates);
  visit("temperature", state.temperature);
  visit("elapsed_s", state.elapsed_s);
  visit("fraction", state.fraction);
  visit("mean_magnitude", state.mean_magnitude);
  visit("mean_distance", state.mean_distance);
  visit("round_score", state.round_score);
  visit("finished", state.finished);
}

template <class Row, class Visit>
void visit_history(Row& row, const Visit& visit) {
  visit("sweep", row.sweep);
  visit("iterations", row.iterations);
  visit("temperature", row.temperature);
  visit("acceptance", row.acceptance);
  visit("relative_error", row.relative_error);
  visit("seconds", row.seconds);
}

std::vector<SliceDataset> datasets_for(const SampleSource& source) {
  std::vector<SliceDataset> datasets = {{samples_name, ElementType::float32, source.channels(), true},
                                        {permutation_name, ElementType::uint32, 1, false}};
  if (source.has_pdf()) datasets.push_back({pdf_name, ElementType::float32, 1, false});
  return datasets;
}

RunFileContent content_of(const RunConfig& config, const SampleSource& source, const EngineState& state,
                          const std::map<std::string, Attribute>& provenance) {
  RunFileContent content;
  content.extents = config.problem.extents;
  content.config = to_toml(config);
  content.datasets = datasets_for(source);
  visit_state(state, [&](const char* name, const auto& value) { content.state[name] = value; });
  const HistoryRow names;
  visit_history(names, [&](const char* name, double) { content.history.push_back({name, {}}); });
  for (const HistoryRow& row : state.history) {
    std::size_t column = 0;
    visit_history(row, [&](const char*, double value) { content.history[column++].second.push_back(value); });
  }
  content.provenance = provenance;
  return content;
}

template <class T>
void append(std::vector<std::byte>& block, const std::vector<T>& values) {
  const auto bytes = std::as_bytes(std::span(values));
  block.insert(block.end(), bytes.begin(), bytes.end());
}

std::vector<float> densities(const SampleSource& source, const std::vector<float>& samples) {
  const auto channels = static_cast<std::size_t>(source.channels());
  std::vector<float> pdf(samples.size() / channels);
  for (std::size_t cell = 0; cell < pdf.size(); ++cell) {
    pdf[cell] = static_cast<float>(source.pdf(samples.data() + cell * channels));
  }
  return pdf;
}

// A block of bytes for every number, in the order of visit_state, then the history.
std::string packed(const EngineState& state) {
  std::string bytes;
  const auto put = [&bytes](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); };
  const std::uint64_t rows = state.history.size();
  put(&rows, sizeof(rows));
  put(state.history.data(), rows * sizeof(HistoryRow));
  visit_state(state, [&](const char*, const auto& value) {
    if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, std::string>) put(&value, sizeof(value));
  });
  return bytes + state.finished;
}

EngineState unpacked(const std::string& bytes) {
  EngineState state;
  std::size_t at = 0;
  const auto get = [&](void* data, std::size_t size) {
    NOISELOOM_CHECK_LE(at + size, bytes.size());
    std::memcpy(data, bytes.data() + at, size);
    at += size;
  };
  std::uint64_t rows = 0;
  get(&rows, sizeof(rows));
  state.history.resize(rows);
  if (rows > 0) get(state.history.data(), rows * sizeof(HistoryRow));
  visit_state(state, [&](const char*, auto& value) {
    if constexpr (!std::is_same_v<std::decay_t<decltype(value)>, std::string>) get(&value, sizeof(value));
  });
  state.finished = bytes.substr(at);
  return state;
}

}  // namespace

std::string inputs_digest(const RunConfig& config) {
  if (config.written_paths.empty()) return "";
  Digest digest;
  std::vector<std::byte> bytes;
  for (const auto& [path, written] : config.written_paths) {
    const int fd = posix_file_ops().open(path);
    bytes.resize(posix_file_ops().size(fd));
    posix_file_ops().read(fd, 0, bytes);
    posix_file_ops().close(fd);
    digest.update(bytes);
  }
  return to_hex(digest.value());
}

std::string config_folder(const RunFileContent& content, const std::string& run_file) {
  const auto found = content.provenance.find("config_folder");
  if (found != content.provenance.end() && std::holds_alternative<std::string>(found->second)) {
    std::string folder = std::get<std::string>(found->second);
    if (posix_file_ops().exists(folder)) return folder;
  }
  return parent_directory(run_file);
}

std::string save_run(FileOps& ops, const std::string& path, const RunConfig& config, const SampleSource& source,
                     Engine& engine, const Communicator& communicator, const std::string& inputs,
                     const std::map<std::string, Attribute>& provenance) {
  RunFileContent content = content_of(config, source, engine.state(), provenance);
  content.state["inputs"] = inputs;
  std::unique_ptr<RunFileWriter> writer;
  communicator.on_root([&] { writer = std::make_unique<RunFileWriter>(ops, path, content); });
  const auto produce = [&](SliceIndex slice, std::vector<std::byte>& block) {
    block.clear();
    const std::vector<float> samples = engine.samples(slice);
    append(block, samples);
    append(block, engine.permutation(slice));
    if (source.has_pdf()) append(block, densities(source, samples));
  };
  const auto consume = [&](SliceIndex slice, std::span<const std::byte> block) {
    for (std::size_t k = 0; k < content.datasets.size(); ++k) {
      const std::size_t size = bytes_per_slice(content.datasets[k], content.extents);
      writer->write_slice(static_cast<int>(k), slice, block.first(size));
      block = block.subspan(size);
    }
  };
  communicator.stream_to_root(engine.partition(), produce, consume);
  std::string checksum;
  communicator.on_root([&] {
    checksum = writer->checksum(0);
    writer->publish();
  });
  return checksum;
}

EngineState engine_state(const RunFileContent& content) {
  EngineState state;
  visit_state(state, [&](const char* name, auto& value) {
    const auto found = content.state.find(name);
    using Value = std::decay_t<decltype(value)>;
    if (found == content.state.end() || !std::holds_alternative<Value>(found->second)) {
      throw UserError("", fmt::format("/state has no usable attribute \"{}\"; not written by generate", name));
    }
    value = std::get<Value>(found->second);
  });
  for (const auto& [column, values] : content.history) {
    state.history.resize(values.size());
    for (std::size_t row = 0; row < values.size(); ++row) {
      visit_history(state.history[row], [&](const char* name, double& value) {
        if (column == name) value = values[row];
      });
    }
  }
  return state;
}

void restore_run(const RunFileReader* file, const Extents& extents, Engine& engine, const Communicator& communicator) {
  std::string bytes;
  int samples = -1;
  int permutation = -1;
  communicator.on_root([&] {
    bytes = packed(engine_state(file->content()));
    samples = file->dataset(samples_name);
    permutation = file->dataset(permutation_name);
    if (samples < 0 || permutation < 0) throw UserError("", "the run file lacks /samples or /state/permutation");
  });
  communicator.broadcast(bytes);
  const EngineState state = unpacked(bytes);

  const auto cells = static_cast<std::size_t>(extents.cells_per_slice());
  const std::vector<SliceIndex> held = engine.slices_held();
  const Partition& partition = engine.partition();
  std::map<SliceIndex, std::vector<std::uint32_t>> permutations;
  std::map<SliceIndex, std::vector<std::byte>> stored;
  const auto produce = [&](SliceIndex slice, std::vector<std::byte>& block) {
    const auto& datasets = file->content().datasets;
    const std::size_t size = bytes_per_slice(datasets[static_cast<std::size_t>(samples)], extents);
    block.resize(cells * sizeof(std::uint32_t) + size);
    file->read_slice(permutation, slice, std::span(block).first(cells * sizeof(std::uint32_t)));
    file->read_slice(samples, slice, std::span(block).last(size));
  };
  const auto consume = [&](SliceIndex slice, std::span<const std::byte> block) {
    const bool own = partition.owner(slice) == communicator.rank();
    if (!own && std::find(held.begin(), held.end(), slice) == held.end()) return;
    std::vector<std::uint32_t>& ids = permutations[slice];
    ids.resize(cells);
    std::memcpy(ids.data(), block.data(), cells * sizeof(std::uint32_t));
    if (own)
      stored[slice].assign(block.begin() + static_cast<std::ptrdiff_t>(cells * sizeof(std::uint32_t)), block.end());
  };
  communicator.stream_to_all(extents.num_slices(), produce, consume);
  engine.restore(state, [&](SliceIndex slice) { return permutations.at(slice); });
  communicator.together([&] {
    for (const auto& [slice, expected] : stored) {
      const std::vector<float> found = engine.samples(slice);
      if (expected.size() != found.size() * sizeof(float) ||
          std::memcmp(expected.data(), found.data(), expected.size()) != 0) {
        throw UserError(
            "", fmt::format("slice {}: the stored samples are not those that the config yields now; has a sample "
                            "file changed, or the program's version?",
                            slice));
      }
    }
  });
}

}  // namespace noiseloom
