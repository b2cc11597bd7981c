#include "noiseloom/config/stored_config.h"

#include <fmt/format.h>

#include "noiseloom/config/inputs.h"
#include "noiseloom/files/file_ops.h"
#include "noiseloom/samples/sample_space.h"

namespace noiseloom {

std::string config_folder(const RunFileContent& content, const std::string& run_file) {
  const auto found = content.provenance.find("config_folder");
  if (found != content.provenance.end() && std::holds_alternative<std::string>(found->second)) {
    std::string folder = std::get<std::string>(found->second);
    if (posix_file_ops().exists(folder)) return folder;
  }
  return parent_directory(run_file);
}

namespace {

// Whoever reads the samples goes by the config.
void require_same_layout(const RunFileContent& content, const RunConfig& config, const std::string& path) {
  const Extents& extents = config.problem.extents;
  if (!(content.extents == extents)) {
    throw UserError(path,
                    fmt::format("holds {}, but its /config says {}", content.extents.to_string(), extents.to_string()));
  }
  const SampleSpec& spec = config.problem.samples;
  for (const SliceDataset& dataset : content.datasets) {
    if (dataset.name != "/samples") continue;
    const bool typed = dataset.type == ElementType::float32 && dataset.channel_axis;
    if (typed && (spec.is_file() || dataset.channels == num_channels(spec))) return;
    throw UserError(path, fmt::format("/samples: has {} channels{}, but {} samples are {} of float32", dataset.channels,
                                      typed ? "" : ", not of float32", spec.space, num_channels(spec)));
  }
  throw UserError(path, "holds no /samples");
}

}  // namespace

RunConfig stored_config(const RunFileContent& content, const std::string& path,
                        const std::vector<std::string>& overrides) {
  RunConfig config =
      parse_config(content.config, path + ": /config", config_folder(content, path), overrides, MissingFiles::accepted);
  take_inputs(config, content.inputs, path);
  require_same_layout(content, config, path);
  return config;
}

}  // namespace noiseloom
