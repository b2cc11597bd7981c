#include "run/checkpoints/checkpoint_parts.h"

#include <cmath>
#include <memory>

#include "noiseloom/anneal/swap_optimizer.h"
#include "noiseloom/construct/slice_construction.h"
#include "noiseloom/construct/void_and_cluster.h"
#include "noiseloom/dist/activity.h"
#include "noiseloom/run/checkpoint.h"

namespace noiseloom {
namespace {

const char* method_name(Method method) {
  switch (method) {
    case Method::anneal:
      return "anneal";
    case Method::fast:
      return "fast";
    case Method::void_and_cluster:
      return "void-and-cluster";
    case Method::construct:
      return "construct";
    case Method::automatic:
      return "auto";
  }
  return "";
}

const char* type_name(ElementType type) {
  switch (type) {
    case ElementType::float32:
      return "float32";
    case ElementType::uint32:
      return "uint32";
    case ElementType::uint64:
      return "uint64";
  }
  return "";
}

std::string described(const SliceDataset& dataset) {
  return fmt::format("{}{}", type_name(dataset.type),
                     dataset.channel_axis ? fmt::format(" of {} channels", dataset.channels) : "");
}

}  // namespace

bool begins_with_arrangement(const RunConfig& config) {
  return config.optimizer.method == Method::construct || config.optimizer.strata > 1 || config.start.is_given();
}

std::int64_t algorithm_of(Method method) {
  switch (method) {
    case Method::anneal:
      return anneal_algorithm;
    case Method::fast:
      return fast_algorithm;
    case Method::void_and_cluster:
      return void_and_cluster_algorithm;
    case Method::construct:
      return construct_algorithm;
    case Method::automatic:
      break;
  }
  return 0;
}

std::int64_t stored_algorithm(const RunFileContent& content, const std::string& path) {
  const auto found = content.state.find("algorithm");
  if (found == content.state.end()) return 1;
  const auto* const number = std::get_if<std::int64_t>(&found->second);
  if (number == nullptr || *number < 1) throw UserError(path, "/state/@algorithm: must be a number from 1 on");
  return *number;
}

void require_same_algorithm(const RunFileContent& content, Method method, const std::string& path) {
  const std::int64_t stored = stored_algorithm(content, path);
  if (stored == algorithm_of(method)) return;
  const auto version = content.provenance.find("version");
  const bool named = version != content.provenance.end() && std::holds_alternative<std::string>(version->second);
  throw UserError(
      path, fmt::format("begun with algorithm {} of {}{}, but this program has algorithm {}, which makes other bytes: "
                        "finish it with a program of algorithm {}, or start afresh (another output, or --overwrite)",
                        stored, method_name(method),
                        named ? fmt::format(" (noiseloom {})", std::get<std::string>(version->second)) : "",
                        algorithm_of(method), stored));
}

void ContentFaults::throw_if_any() {
  if (faults_.empty()) return;
  faults_.push_back({path_, "its digests are right, so it is not damaged: something other than generate wrote it"});
  throw UserError(std::exchange(faults_, {}));
}

void check_datasets(const RunFileContent& content, const std::vector<SliceDataset>& expected, ContentFaults& faults) {
  for (const SliceDataset& dataset : expected) {
    const auto found = std::find_if(content.datasets.begin(), content.datasets.end(),
                                    [&](const SliceDataset& stored) { return stored.name == dataset.name; });
    if (found == content.datasets.end()) {
      faults.require(false, fmt::format("has no {}", dataset.name));
    } else {
      faults.require(*found == dataset,
                     fmt::format("{}: is {}, must be {}", dataset.name, described(*found), described(dataset)));
    }
  }
}

bool is_count(double value, double least, double most) {
  return value >= least && value <= most && value == std::floor(value);
}

bool is_finite_positive_or_zero(double value) { return value >= 0 && std::isfinite(value); }

std::string permutation_fault(std::span<const SampleId> ids) {
  std::vector<bool> seen(ids.size());
  for (std::size_t cell = 0; cell < ids.size(); ++cell) {
    const std::uint32_t id = ids[cell].value();
    if (id >= ids.size()) return fmt::format("cell {} holds id {}, must be below {}", cell, id, ids.size());
    if (seen[id]) return fmt::format("cell {} holds id {}, which another cell holds too", cell, id);
    seen[id] = true;
  }
  return "";
}

std::string publish_run(FileOps& ops, const std::string& path, const RunFileContent& content,
                        const Distribution& distribution, const Communicator& communicator,
                        const ProduceSlice& produce) {
  const Activity writing(Activity::Kind::writing, "saves");
  std::unique_ptr<RunFileWriter> writer;
  communicator.on_root([&] { writer = std::make_unique<RunFileWriter>(ops, path, content); });
  for (std::size_t dataset = 0; dataset < content.datasets.size(); ++dataset) {
    communicator.stream_to_root(
        distribution, [&](SliceIndex slice, std::vector<std::byte>& block) { produce(dataset, slice, block); },
        [&](SliceIndex slice, std::span<const std::byte> block) {
          writer->write_slice(static_cast<int>(dataset), slice, block);
        });
  }
  std::string checksum;
  communicator.on_root([&] {
    checksum = writer->checksum(0);
    writer->complete();
  });
  // All ranks have come here: a rank 0 that was cut off from the others gives nothing its name.
  communicator.on_root([&] { writer->publish(); });
  return checksum;
}

}  // namespace noiseloom
