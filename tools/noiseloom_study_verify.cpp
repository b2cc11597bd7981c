// verify: what textures are, and what is wrong with them.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <string>

#include "noiseloom/core/parallel.h"
#include "noiseloom/files/bank_index.h"
#include "noiseloom/measure/members.h"
#include "noiseloom/measure/verify.h"
#include "noiseloom_options.h"
#include "noiseloom_study.h"

namespace noiseloom {
namespace {

constexpr int exit_something_wrong = 3;

struct VerifyArguments {
  TextureArguments texture;
  ResultOptions result;
};

bool is_bank(const std::string& name) {
  std::error_code unknown;
  return std::filesystem::is_directory(name, unknown) && std::filesystem::exists(index_path(name), unknown);
}

int run_verify(const VerifyArguments& arguments) {
  ThreadPool pool(threads_of(arguments.texture));
  std::string text;
  std::vector<Fault> faults;
  bool sound = true;
  for (const std::string& name : arguments.texture.files) {
    try {
      if (is_bank(name)) {
        const MembersVerification found = verify_members(member_files(name), pool);
        sound = sound && found.is_sound();
        if (!text.empty()) text += arguments.result.json ? ",\n " : "\n";
        text += (arguments.result.json ? members_json : members_text)(found, name);
        continue;
      }
      const std::optional<RunConfig> config = config_of(arguments.texture, name);
      const StoredTexture stored = load_stored_texture(name, config, arguments.texture.reading);
      const Verification verification = verify_texture(stored, name, config.has_value(), pool);
      sound = sound && verification.is_sound();
      if (!text.empty()) text += arguments.result.json ? ",\n " : "\n";
      text += (arguments.result.json ? verification_json : verification_text)(verification, stored, name);
    } catch (const UserError& error) {
      faults.insert(faults.end(), error.faults().begin(), error.faults().end());
    }
  }
  throw_if_any(std::move(faults));
  print_result(arguments.result, text, arguments.texture.files.size() == 1 ? text + "\n" : "[" + text + "]\n");
  return sound ? 0 : exit_something_wrong;
}

}  // namespace

std::vector<MemberFile> member_files(const std::string& folder) {
  std::vector<MemberFile> files;
  for (const DoneMember& member : done_members(folder)) {
    files.push_back({member.name, member_path(folder, member.name), member.checksum, member.settings, member.seed});
  }
  return files;
}

void add_verify(CLI::App& app, int& status) {
  const auto arguments = std::make_shared<VerifyArguments>();
  auto* const command = app.add_subcommand("verify", "What a texture is, and what is wrong with it");
  add_texture_arguments(*command, arguments->texture);
  add_result_options(*command, arguments->result, ShowsProgress::no, "of several files a list of them");
  command->footer(
      "Says what it takes a file for, and why; then looks at range, support and unit length, the histogram of all "
      "slices and\n"
      "of each (gamma, contrast, levels that are missing), alpha that was copied or multiplied in, slices that repeat, "
      "are\n"
      "mirrored, missing or swapped, edges that do not tile, time that is white, peaks in the spectrum, nets, and R "
      "under\n"
      "the filters that textures are published for. What chance could have made with odds above one in a million is "
      "no\n"
      "fault. Exit status 3 where something is wrong.\n"
      "Of a bank's folder: whether members of different seeds are correlated, at any shift and in any band of "
      "frequencies, and\n"
      "whether those of the same settings are alike in distribution. Pairs of one seed or of different sizes are "
      "left out, and\n"
      "counted.\n\n"
      "  noiseloom verify stbn_vec2_2Dx1D_128x128x64_{}.png\n"
      "  noiseloom verify seeds                                    the folder that noiseloom bank made\n"
      "  noiseloom verify mine.ktx2 --set texture.samples=disk     what the values are, where the file does not say\n");
  command->callback([arguments, &status] { status = run_verify(*arguments); });
}

}  // namespace noiseloom
