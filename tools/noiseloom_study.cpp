// The program behind `noiseloom export`, `score`, `verify` and all others but generate, plan and info: what needs image
// libraries and no MPI.
#include "noiseloom_study.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <climits>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <exception>
#include <filesystem>
#include <new>

#include "noiseloom/core/console.h"
#include "noiseloom/core/error.h"
#include "noiseloom/core/standard_streams.h"
#include "noiseloom/files/image_decoder.h"
#include "noiseloom/image/colour.h"
#include "noiseloom/published/line.h"
#include "noiseloom_options.h"

namespace noiseloom {
namespace {

constexpr int exit_done = 0;
constexpr int exit_environment = 1;
constexpr int exit_user = 2;

std::vector<std::string> words_given;  // of the command line, behind the program's name

// As a shell takes the word.
std::string quoted(const std::string& word) {
  constexpr const char* plain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=.,:/@%";
  if (!word.empty() && word.find_first_not_of(plain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? "'\\''" : std::string(1, c);
  return text + "'";
}

int run_command(int argc, char** argv) {
  if (argc > 1 && find_published_program(argv[1]) != nullptr)
    return run_published(argv[1], std::vector<std::string>(argv + 2, argv + argc));
  CLI::App app("Look at sampling-noise textures, score them, and turn run files into images", "noiseloom");
  app.require_subcommand(1);
  add_export(app);
  add_score(app);
  add_analyze(app);
  add_pixels(app);
  int status = exit_done;
  add_accuracy(app, status);
  add_render(app, status);
  add_verify(app, status);
  add_compare(app);
  read_options(app, argc, argv);
  return status;
}

int run(int argc, char** argv) {
  set_image_decoder(read_colour);
  words_given.assign(argv + std::min(argc, 1), argv + argc);
  try {
    const int status = run_command(argc, argv);
    flush_standard_output();
    return status;
  } catch (const UserError& error) {
    const std::size_t count = error.faults().size();
    print_error(fmt::format("{}\n{} error{}; nothing was done\n", error.what(), count, count == 1 ? "" : "s"));
    return exit_user;
  } catch (const std::bad_alloc&) {
    print_error("out of memory: the system gives this process no more (ulimit -v, a container's limit?)\n");
    return exit_environment;
  } catch (const std::exception& error) {
    print_error(fmt::format("{}\n", error.what()));
    return exit_environment;
  }
}

}  // namespace

std::string program_beside() {
  std::array<char, PATH_MAX> self{};
  const ssize_t length = readlink("/proc/self/exe", self.data(), self.size() - 1);
  if (length <= 0) return "noiseloom";
  const std::filesystem::path beside = std::filesystem::path(self.data()).parent_path() / "noiseloom";
  return std::filesystem::exists(beside) ? beside.string() : "noiseloom";
}

void refuse_unfit_folder(const std::string& folder) {
  if (folder.empty()) throw UserError("command line", "-o: the name of the folder is empty");
  if (folder == "-")
    throw UserError("command line", "-o -: a report is a folder of files, which cannot go to standard output");
  const std::filesystem::path path(folder);
  std::error_code absent;
  if (std::filesystem::exists(path, absent) && !std::filesystem::is_directory(path, absent))
    throw UserError("command line", fmt::format("-o {}: is a file, must be a folder", folder));
  for (const char* const ending : {".html", ".htm", ".pdf"})
    if (path.extension() == ending && !std::filesystem::is_directory(path))
      throw UserError(
          "command line",
          fmt::format("-o {}: a report is a folder of files, report.html among them; give the folder's name", folder));
}

ReportOrigin report_origin() {
  ReportOrigin origin{NOISELOOM_VERSION, "", "noiseloom"};
  for (const std::string& word : words_given) origin.command += " " + quoted(word);
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  char date[32];
  if (::gmtime_r(&now, &utc) != nullptr && std::strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", &utc) > 0)
    origin.date = date;
  return origin;
}

}  // namespace noiseloom

int main(int argc, char** argv) {
  std::signal(SIGXFSZ, SIG_IGN);  // a full quota is then an error that is told
  noiseloom::reserve_standard_streams();
  return noiseloom::run(argc, argv);
}
