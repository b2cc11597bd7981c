#include "noiseloom/run/checkpoint.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "noiseloom/files/digest.h"
#include "run/checkpoint_parts.h"

namespace noiseloom {
namespace {

const char* const permutation_name = "/state/permutation";
const char* const pdf_name = "/pdf";

constexpr auto visit_state = [](auto& state, const auto& visit) {
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
  visit("relative_error", state.relative_error);
  visit("iterations", state.iterations);
  visit("scored_iterations", state.scored_iterations);
  visit("scored_step", state.scored_step);
  visit("finished", state.finished);
};

constexpr auto visit_row = [](auto&& row, const auto& visit) {
  visit("sweep", row.sweep);
  visit("iterations", row.iterations);
  visit("temperature", row.temperature);
  visit("acceptance", row.acceptance);
  visit("relative_error", row.relative_error);
  visit("seconds", row.seconds);
};

std::vector<float> densities(const SampleSource& source, const std::vector<float>& samples) {
  const auto channels = static_cast<std::size_t>(source.channels());
  std::vector<float> pdf(samples.size() / channels);
  for (std::size_t cell = 0; cell < pdf.size(); ++cell) {
    pdf[cell] = static_cast<float>(source.pdf(samples.data() + cell * channels));
  }
  return pdf;
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

std::vector<SliceDataset> run_datasets(const SampleSource& source) {
  std::vector<SliceDataset> datasets = {{samples_name, ElementType::float32, source.channels(), true},
                                        {permutation_name, ElementType::uint32, 1, false}};
  if (source.has_pdf()) datasets.push_back({pdf_name, ElementType::float32, 1, false});
  return datasets;
}

std::string save_run(FileOps& ops, const std::string& path, const RunConfig& config, const SampleSource& source,
                     SwapOptimizer& engine, const Communicator& communicator, const std::string& inputs,
                     const std::map<std::string, Attribute>& provenance) {
  RunFileContent content = content_of(config, engine.state(), visit_state, visit_row, inputs, provenance);
  content.datasets = run_datasets(source);
  const auto produce = [&](std::size_t dataset, SliceIndex slice, std::vector<std::byte>& block) {
    block.clear();
    const std::string& name = content.datasets[dataset].name;
    if (name == permutation_name) {
      append(block, engine.permutation(slice));
    } else if (name == pdf_name) {
      append(block, densities(source, engine.samples(slice)));
    } else {
      append(block, engine.samples(slice));
    }
  };
  return publish_run(ops, path, content, engine.partition(), communicator, produce);
}

// Files of version 0.1.0 do not say where R was evaluated last: where the last row of the history is.
SwapState engine_state(const RunFileContent& content) {
  if (content.state.contains("scored_iterations")) return state_of<SwapState>(content, visit_state, visit_row);
  RunFileContent completed = content;
  double error = 0;
  double iterations = 0;
  for (const auto& [column, values] : content.history) {
    if (column == "relative_error" && !values.empty()) error = values.back();
    if (column == "iterations" && !values.empty()) iterations = values.back();
  }
  completed.state["relative_error"] = error;
  completed.state["iterations"] = completed.state["scored_iterations"] = std::int64_t(iterations);
  completed.state["scored_step"] = std::int64_t{0};
  return state_of<SwapState>(completed, visit_state, visit_row);
}

void restore_run(const RunFileReader* file, const Extents& extents, SwapOptimizer& engine,
                 const Communicator& communicator) {
  SwapState state;
  int samples = -1;
  int permutation = -1;
  communicator.on_root([&] {
    state = engine_state(file->content());
    samples = file->dataset(samples_name);
    permutation = file->dataset(permutation_name);
    if (samples < 0 || permutation < 0) throw UserError("", "the run file lacks /samples or /state/permutation");
  });
  broadcast_state(state, visit_state, communicator);

  const auto cells = static_cast<std::size_t>(extents.cells_per_slice());
  const Partition& partition = engine.partition();
  std::vector<SliceIndex> wanted = engine.slices_held();
  std::sort(wanted.begin(), wanted.end());
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
    std::vector<std::uint32_t>& ids = permutations[slice];
    ids.resize(cells);
    std::memcpy(ids.data(), block.data(), cells * sizeof(std::uint32_t));
    if (own)
      stored[slice].assign(block.begin() + static_cast<std::ptrdiff_t>(cells * sizeof(std::uint32_t)), block.end());
  };
  communicator.stream_from_root(wanted, produce, consume);
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
