#include "noiseloom/config/stored_config.h"

#include "noiseloom/files/file_ops.h"

namespace noiseloom {

std::string config_folder(const RunFileContent& content, const std::string& run_file) {
  const auto found = content.provenance.find("config_folder");
  if (found != content.provenance.end() && std::holds_alternative<std::string>(found->second)) {
    std::string folder = std::get<std::string>(found->second);
    if (posix_file_ops().exists(folder)) return folder;
  }
  return parent_directory(run_file);
}

RunConfig stored_config(const RunFileContent& content, const std::string& path,
                        const std::vector<std::string>& overrides) {
  return parse_config(content.config, path + ": /config", config_folder(content, path), overrides,
                      MissingFiles::accepted);
}

}  // namespace noiseloom
