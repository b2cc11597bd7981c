#include <algorithm>
#include <map>
#include <optional>

#include "measure/members_parts.h"

namespace noiseloom::members {

DistanceKind kind_of(const StoredTexture& stored) {
  return stored.config ? distance_kind(stored.config->problem.samples, stored.texture.channels)
                       : DistanceKind::euclidean;
}

OfOneSize size_of(const StoredTexture& stored) {
  return {stored.texture.extents, stored.texture.channels, kind_of(stored) == DistanceKind::circle, {}};
}

StoredTexture load(const MemberFile& file) { return load_stored_texture(file.path, std::nullopt); }

std::vector<OfOneSize> by_size(const std::vector<MemberFile>& files, ThreadPool& pool) {
  std::map<std::string, std::vector<std::size_t>> by_settings;
  for (std::size_t i = 0; i < files.size(); ++i) by_settings[files[i].settings].push_back(i);
  std::vector<OfOneSize> each;
  for (const auto& [settings, numbers] : by_settings) each.push_back({{}, 0, false, numbers});
  pool.for_each(static_cast<std::int64_t>(each.size()), [&](std::int64_t i, int) {
    OfOneSize& one = each[static_cast<std::size_t>(i)];
    OfOneSize size = size_of(load(files[one.numbers.front()]));
    size.numbers = std::move(one.numbers);
    one = std::move(size);
  });
  std::vector<OfOneSize> sizes;
  for (OfOneSize& one : each) {
    const auto same =
        std::find_if(sizes.begin(), sizes.end(), [&](const OfOneSize& other) { return other.is_same(one); });
    if (same == sizes.end()) {
      sizes.push_back(std::move(one));
    } else {
      same->numbers.insert(same->numbers.end(), one.numbers.begin(), one.numbers.end());
    }
  }
  for (OfOneSize& size : sizes) std::sort(size.numbers.begin(), size.numbers.end());
  return sizes;
}

}  // namespace noiseloom::members
