// What images and textures that were exported here say of themselves.
#include <filesystem>

#include "image/loaders/texture_loaders.h"
#include "noiseloom/image/image_reader.h"
#include "noiseloom/image/sequence.h"

namespace noiseloom {
namespace loaders {

std::optional<OwnFacts> own_facts_of_images(const std::string& path, const std::vector<std::string>& overrides) {
  const bool many = std::filesystem::is_directory(path) || !std::filesystem::exists(path);
  const std::string first = many ? find_sequence(path).front() : path;
  return own_facts(ImageReader(first).facts(), path, overrides);
}

std::string reading_of_layout(const std::string& layout) {
  return layout == "strip" || layout == "row" || layout.starts_with("atlas:") ? layout : "";
}

}  // namespace loaders

std::optional<RunConfig> config_in_images(const std::string& path, const std::vector<std::string>& overrides) {
  std::optional<OwnFacts> own = loaders::own_facts_of_images(path, overrides);
  return own ? std::optional(std::move(own->config)) : std::nullopt;
}

}  // namespace noiseloom
