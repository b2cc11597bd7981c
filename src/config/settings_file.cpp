#include "noiseloom/config/settings_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include "config/override.h"
#include "config/tree_limits.h"
#include "noiseloom/config/settings_writer.h"

namespace noiseloom::settings {
namespace {

struct CloseFile {
  void operator()(std::FILE* file) const { std::fclose(file); }
};

[[noreturn]] void fail_to_read(const std::string& path, int error) {
  throw EnvironmentError(path + ": cannot be read: " + std::strerror(error == 0 ? EIO : error));
}

[[noreturn]] void refuse_format(const std::string& path, std::string_view format, std::string_view noun) {
  const std::string_view hint =
      format == "a run file" ? "; \"noiseloom info --json\" shows the config that it was made with" : "";
  throw UserError(path, fmt::format("is {}, must be a {} (TOML){}", format, noun, hint));
}

// At most one byte more than a text may have, so that an endless or huge file costs no memory.
std::string read_at_most(const std::string& path, std::size_t max_bytes) {
  errno = 0;
  const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
  if (!file) fail_to_read(path, errno);
  std::string text;
  std::array<char, 1 << 16> part{};
  while (text.size() < max_bytes) {
    const std::size_t got = std::fread(part.data(), 1, std::min(part.size(), max_bytes - text.size()), file.get());
    text.append(part.data(), got);
    if (got == 0) break;
  }
  if (std::ferror(file.get()) != 0) fail_to_read(path, errno);
  return text;
}

}  // namespace

Source load_source(const std::string& path, std::string_view noun) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw UserError(path, "no such file");
  if (std::filesystem::is_directory(status)) {
    throw UserError(path, fmt::format("is a folder, must be a {} (TOML)", noun));
  }
  Source source{.text = read_at_most(path, max_text_bytes + 1),
                .name = path,
                .folder = std::filesystem::path(path).parent_path().string()};
  if (source.text.size() > max_text_bytes) {
    if (const auto format = foreign_format(source.text); !format.empty()) refuse_format(path, format, noun);
    throw UserError(path, fmt::format("longer than {} MiB, must be a {} (TOML)", max_text_bytes >> 20, noun));
  }
  return source;
}

WrittenPaths parse_into(const FileKind& kind, const Owners& owners, const Source& source,
                        const std::vector<std::string>& overrides, MissingFiles missing) {
  Value root;
  try {
    root = parse_tree(source.text, source.name);
  } catch (const UserError&) {
    const std::string_view format = foreign_format(source.text);
    if (format.empty() || format == "text in UTF-16") throw;
    refuse_format(source.name, format, kind.noun);
  }
  rename_former_keys(kind, root);
  std::vector<Fault> override_faults;
  for (const std::string& text : overrides) apply_override(kind, root, text, override_faults);
  Reader reader(kind, source.folder, missing);
  reader.read(root, owners);
  std::vector<Fault> faults = reader.faults();
  faults.insert(faults.end(), override_faults.begin(), override_faults.end());
  throw_if_any(std::move(faults));
  return reader.written_paths();
}

std::string stored_text(const FileKind& kind, const Owners& owners, const WrittenPaths& written_paths) {
  return Writer(kind, written_paths).text(owners);
}

}  // namespace noiseloom::settings
