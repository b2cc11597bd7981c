// noiseloom: generate, plan and info; everything else is run in noiseloom-study, which links the image libraries.

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <new>
#include <string>
#include <system_error>
#include <vector>

#include "noiseloom/core/console.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/standard_streams.h"
#include "noiseloom/files/run_file.h"
#include "noiseloom_commands.h"
#include "noiseloom_images.h"

namespace noiseloom {
namespace {

constexpr const char* usage =
    R"(noiseloom weaves sampling-noise textures: arrays that give every pixel of every frame a random
value whose error your denoiser removes best.

  noiseloom generate CONFIG.toml -o RUN.h5     make a texture (alone or under mpirun/srun)
  noiseloom bank BANK.toml -o DIR              many textures: seeds, or a matrix of settings, over one config
  noiseloom plan CONFIG.toml [--ranks N]       memory, messages and time, before a long run
  noiseloom info RUN.h5                        what a run file holds and how far it got

  noiseloom export RUN.h5 -o DIR               run file to images, textures (KTX2, DDS), arrays, headers, shaders
  noiseloom score FILE [--config C.toml]       relative error of a run file or of anybody's images
  noiseloom verify FILE...                     what a texture is, and what is wrong with it
  noiseloom compare FILE FILE...               textures side by side, under the same filters
  noiseloom analyze FILE -o DIR                spectra and convergence as report.html
  noiseloom accuracy CONFIG.toml -o DIR        what accuracy costs: error against seconds, as report.html
  noiseloom render SCENE.toml -o DIR           what noises are worth in a scene: errors after your filters

  noiseloom fastnoise SPACE DIST ...           a line of the published program of filter-adapted noise
  noiseloom stbn-scalar [OPTIONS]              a line of the published maker of scalar blue noise
  noiseloom stbn-vector [OPTIONS]              a line of the published maker of blue noise of vectors

  noiseloom COMMAND --help                     the options of a command
  noiseloom --help-config                      every setting of a config
  noiseloom render --help-scene                every setting of a scene
  noiseloom bank --help-bank                   every setting of a bank
  noiseloom --version

A first texture:
  noiseloom generate configs/quick.toml -o quick.h5 && noiseloom export quick.h5 -o quick

Exit status: 0 done; 1 the environment failed (disk, MPI); 2 the input is wrong (nothing was started); 3 what a
scene expects did not come out, or verify found something wrong; 75 stopped early with everything saved: run the same
command again, generate and accuracy with --resume; 76 a rank was lost or stuck: run it again with --resume, what was
saved last is whole.
)";

const std::vector<std::string>& study_commands() {
  static const std::vector<std::string> commands = {"export",   "score",  "verify",    "compare",     "analyze",
                                                    "accuracy", "render", "fastnoise", "stbn-scalar", "stbn-vector"};
  return commands;
}

bool is_one_of(const std::string& word, const std::vector<std::string>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

// Replaces this process by noiseloom-study, installed beside this program.
int run_study(char** argv) {
  if (const std::string beside = study_beside(); !beside.empty()) execv(beside.c_str(), argv);
  execvp("noiseloom-study", argv);
  print_error(fmt::format("noiseloom-study: {}; it belongs beside noiseloom\n", std::strerror(errno)));
  return exit_environment;
}

// A file in the place of a command: the command that is most likely meant.
std::string command_for_file(const std::string& word) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(word, error)) return "";
  if (word.ends_with(".toml")) return fmt::format("noiseloom generate {} -o RUN.h5", word);
  return fmt::format("noiseloom {} {}", looks_like_run_file(word) ? "info" : "score", word);
}

int unknown_command(const std::string& word) {
  std::vector<std::string> known = study_commands();
  known.insert(known.end(),
               {"generate", "bank", "plan", "info", "help", "version", "--help", "--help-config", "--version"});
  const std::string near = nearest_word(word, known);
  const std::string for_file = command_for_file(word);
  std::string meant = near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near);
  if (!for_file.empty()) meant = fmt::format(", but a file; did you mean {}?", for_file);
  print_error(fmt::format("noiseloom: \"{}\": unknown command{}; see noiseloom --help\n", word, meant));
  return exit_user;
}

// The commands whose result is what they print: it must arrive whole, or the exit status says that it did not.
int print_result(const std::string& command, int argc, char** argv) {
  if (command.empty()) {
    print_error(usage);
    return exit_user;
  }
  int status = exit_done;
  if (is_one_of(command, {"--help", "-h", "help"})) {
    fmt::print("{}", usage);
  } else if (is_one_of(command, {"--version", "-V", "version"})) {
    fmt::print("noiseloom {}\n", NOISELOOM_VERSION);
  } else if (is_one_of(command, {"plan", "--help-config"})) {
    status = run_plan(argc, argv);
  } else if (command == "info") {
    status = run_info(argc, argv);
  } else {
    status = unknown_command(command);
  }
  flush_standard_output();
  return status;
}

// The same, with what the printing library throws in the words of flush_standard_output.
int run_printing(const std::string& command, int argc, char** argv) {
  try {
    return print_result(command, argc, argv);
  } catch (const std::system_error& error) {
    if (std::ferror(stdout) == 0) throw;
    throw EnvironmentError("standard output: cannot be written: " + error.code().message());
  }
}

int run(int argc, char** argv) {
  std::string command = argc > 1 ? argv[1] : "";
  std::array<char, 7> help_option = {"--help"};
  std::array<char*, 4> help_words = {argv[0], argc > 2 ? argv[2] : nullptr, help_option.data(), nullptr};
  if (command == "help" && argc > 2) {  // "help plan" is "plan --help"
    argc = 3;
    argv = help_words.data();
    command = argv[1];
  }
  if (command == "generate") return run_generate(argc, argv);
  if (command == "bank") return run_bank(argc, argv);
  if (is_one_of(command, study_commands())) return run_study(argv);
  return run_printing(command, argc, argv);
}

}  // namespace

void print_faults(const std::string& faults) {
  const auto count = 1 + std::count(faults.begin(), faults.end(), '\n');
  print_error(fmt::format("{}\n{} {}; nothing was started\n", faults, count, count == 1 ? "error" : "errors"));
}

}  // namespace noiseloom

int main(int argc, char** argv) {
  using namespace noiseloom;
  reserve_standard_streams();
  let_study_decode_images();
  try {
    return run(argc, argv);
  } catch (const UserError& error) {
    print_faults(error.what());
    return exit_user;
  } catch (const std::bad_alloc&) {
    print_error("noiseloom: out of memory\n");
  } catch (const std::exception& error) {
    print_error(fmt::format("noiseloom {}: {}\n", argc > 1 ? argv[1] : "", error.what()));
  }
  return exit_environment;
}
