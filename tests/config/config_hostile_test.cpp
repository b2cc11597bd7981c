// Configs that nobody means: too deep, too long, not TOML at all, numbers at the ends of their ranges. Each is read as
// it is written or refused with its line and key; none ends the program.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <clocale>
#include <filesystem>
#include <fstream>
#include <locale>

#include "config/config_support.h"
#include "noiseloom/config/tree.h"

namespace noiseloom {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

std::string repeated(const std::string& text, int times) {
  std::string result;
  for (int i = 0; i < times; ++i) result += text;
  return result;
}

TEST(ConfigLimits, LongDottedKeysAreRefused) {
  const std::string why = "a key of more than 32 parts; no setting has that many";
  for (const int parts : {33, 40, 8000, 1000000}) {
    const std::string key = "a" + repeated(".a", parts - 1);
    EXPECT_THAT(faults_of("\n\n" + key + " = 1\n"), ElementsAre("run.toml:3: " + why)) << parts;
    EXPECT_THAT(faults_of("[" + key + "]\n"), ElementsAre("run.toml:1: " + why)) << parts;
    EXPECT_THAT(faults_of("[[" + key + "]]\n"), ElementsAre("run.toml:1: " + why)) << parts;
    EXPECT_THAT(faults_of("x = { " + key + " = 1 }\n"), ElementsAre("run.toml:1: " + why)) << parts;
    EXPECT_THAT(faults_of("\"#\" = 1 # comment\n" + key + " = 1\n"), ElementsAre("run.toml:2: " + why)) << parts;
  }
  const std::string quoted = "\"a\"" + repeated(" . 'b'", 40);
  EXPECT_THAT(faults_of(quoted + " = 1\n"), ElementsAre("run.toml:1: " + why));
  EXPECT_THAT(faults_of("x = \"\"\"\n'''\\\"\"\" \n\"\"\"\na" + repeated(".a", 40) + " = 1\n"),
              ElementsAre("run.toml:4: " + why));
}

TEST(ConfigLimits, DeepNestingIsRefused) {
  const std::string why = "tables and lists more than 32 deep; no setting is";
  for (const int depth : {33, 300, 500000}) {
    EXPECT_THAT(faults_of("a = " + repeated("[", depth) + repeated("]", depth) + "\n"),
                ElementsAre("run.toml:1: " + why));
    EXPECT_THAT(faults_of("a = [\n" + repeated("{ b = ", depth) + "1" + repeated("}", depth) + "]\n"),
                ElementsAre("run.toml:2: " + why));
  }
  EXPECT_THAT(faults_of("", {"texture.size=" + repeated("[", 100000)}), Contains(HasSubstr(why)));
}

TEST(ConfigLimits, DepthsBelowTheLimitsAreReadAsTheyAre) {
  EXPECT_THAT(faults_of(ConfigText{}.text() + "a" + repeated(".a", 31) + " = 1\n"),
              ElementsAre(HasSubstr("optimizer.a: unknown key")));
  EXPECT_THAT(faults_of(ConfigText{}.text() + "a = " + repeated("[", 32) + repeated("]", 32) + "\n"),
              ElementsAre(HasSubstr("optimizer.a: unknown key")));
  // Dots and brackets of numbers, comments and strings do not count.
  EXPECT_THAT(faults_of(ConfigText{}.text() + "#" + repeated(".", 99) + repeated("[", 99) + "\na = [" +
                        repeated("1.5, ", 99) + "'" + repeated(".[", 99) + "', \"\\\"" + repeated(".[", 99) + "\"]\n"),
              ElementsAre(HasSubstr("optimizer.a: unknown key")));
}

TEST(ConfigLimits, LongOverridesAreRefused) {
  EXPECT_THAT(faults_of(ConfigText{}.text(), {"a" + repeated(".a", 60000) + "=1"}),
              ElementsAre(HasSubstr("must be KEY=VALUE")));
  EXPECT_THAT(faults_of(ConfigText{}.text(), {"texture.size" + repeated(".a", 25) + "=1"}), Not(IsEmpty()));
}

TEST(ConfigLimits, NoMessageIsLongerThanAScreen) {
  const std::string name(100000, 'k');
  const auto faults = faults_of(ConfigText{}.text() + name + " = \"" + name + "\"\n", {"texture.seed=" + name});
  ASSERT_EQ(faults.size(), 2U);
  EXPECT_LT(faults[0].size(), 500U);
  EXPECT_THAT(faults_of(ConfigText{}.text() + "\"a\\nb\\u001b[31m\" = 1\n"),
              ElementsAre(HasSubstr("optimizer.\"a\\u000ab\\u001b[31m\": unknown key")));
}

class ConfigFile : public testing::Test {
 protected:
  void write(const std::string& bytes) { std::ofstream(path_, std::ios::binary) << bytes; }
  std::string fault() const {
    try {
      load_config(path_, {});
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string path_ = testing::TempDir() + "config_file_test.toml";
};

TEST_F(ConfigFile, OfManyMegabytesIsRefused) {
  write("# " + std::string(settings::max_text_bytes - 3, 'x') + "\n");
  EXPECT_THAT(fault(), HasSubstr("texture: missing")) << "4 MiB are read";
  write("# " + std::string(settings::max_text_bytes, 'x') + "\n");
  EXPECT_EQ(fault(), path_ + ": longer than 4 MiB, must be a config (TOML)");
}

TEST_F(ConfigFile, ThatNeverEndsIsRefused) {
  try {
    load_config("/dev/zero", {});
    FAIL();
  } catch (const UserError& error) {
    EXPECT_STREQ(error.what(), "/dev/zero: longer than 4 MiB, must be a config (TOML)");
  }
}

TEST_F(ConfigFile, OfAnotherFormatIsNamed) {
  using namespace std::string_literals;
  const std::string rest = "\0\1\2 = [\xff"s + std::string(100, '\xfe');
  const std::vector<std::pair<std::string, std::string>> formats = {{"noiseloom run file\n"s, "a run file"},
                                                                    {"\x89HDF\r\n\x1a\n"s, "an HDF5 file"},
                                                                    {"\x89PNG\r\n\x1a\n"s, "an image (PNG)"},
                                                                    {"\x76\x2f\x31\x01"s, "an image (OpenEXR)"},
                                                                    {"II*\0"s, "an image (TIFF)"},
                                                                    {"MM\0*"s, "an image (TIFF)"},
                                                                    {"#?RADIANCE\n"s, "an image (Radiance HDR)"},
                                                                    {"\xff\xd8\xff"s, "an image (JPEG)"},
                                                                    {"DDS |"s, "an image (DDS)"},
                                                                    {"\xabKTX 20\xbb\r\n\x1a\n"s, "an image (KTX)"},
                                                                    {"RIFF....WEBP"s, "an image (WebP)"},
                                                                    {"P5\n64 64\n255\n"s, "an image (PGM)"},
                                                                    {"\x93NUMPY"s, "an array (.npy)"},
                                                                    {"PK\x03\x04"s, "a zip archive, such as .npz"},
                                                                    {"\x7f"
                                                                     "ELF"s,
                                                                     "a program"},
                                                                    {" {\n  \"x\": 1,"s, "JSON"},
                                                                    {"<!doctype html>"s, "XML or HTML"}};
  for (const auto& [beginning, name] : formats) {
    write(beginning + rest);
    EXPECT_THAT(fault(), StartsWith(path_ + ": is " + name + ", must be a config (TOML)")) << name;
  }
  write(formats[0].first + std::string(settings::max_text_bytes, 'x'));
  EXPECT_THAT(fault(), AllOf(StartsWith(path_ + ": is a run file"), HasSubstr("noiseloom info --json")));
}

TEST(ConfigText, IsNotMistakenForAnotherFormat) {
  EXPECT_THAT(faults_of("BM = 1\n" + ConfigText{}.text()), ElementsAre(HasSubstr("BM: unknown key")));
  EXPECT_THAT(faults_of("#?RADIANCE\n" + ConfigText{}.text()), IsEmpty());
}

TEST(ConfigText, MayHaveAByteOrderMarkAndAnyLineEnds) {
  const std::string text = ConfigText{}.text();
  const std::string plain = to_toml(parsed(text));
  EXPECT_EQ(to_toml(parsed("\xef\xbb\xbf" + text)), plain);
  std::string crlf;
  for (const char c : text) crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(to_toml(parsed(crlf)), plain);
  EXPECT_EQ(to_toml(parsed(text.substr(0, text.size() - 1))), plain);
  EXPECT_THAT(faults_of(std::string("\xff\xfe[\0t\0", 6)),
              ElementsAre("run.toml:1: not valid TOML: text in UTF-16, must be UTF-8"));
}

TEST(ConfigText, WithNulBytesIsRefusedWithItsLine) {
  using namespace std::string_literals;
  for (const std::string& text :
       {"a\0b = 1\n"s, "[texture]\nseed = 1\0\n"s, "# \0\n"s, "a = \"\0\"\n"s, "a = '\0'\n"s}) {
    EXPECT_THAT(faults_of(text), ElementsAre(HasSubstr("not valid TOML: "))) << text;
  }
  ConfigText config;
  config.samples = "samples = { file = \"a.npy\\u0000.txt\" }";
  EXPECT_THAT(faults_of(config.text()), ElementsAre(HasSubstr("must be the name of a file")));
}

TEST(ConfigText, SyntaxErrorsShowTheLine) {
  EXPECT_THAT(faults_of("[texture]\n  seed = 99999999999999999999\n"),
              ElementsAre(AllOf(StartsWith("run.toml:2: not valid TOML: "), HasSubstr("not representable in 64 bits"),
                                EndsWith("; the line is: seed = 99999999999999999999"))));
  EXPECT_THAT(faults_of("[texture]\nseed = 1\r\nseed = 2\r\n"),
              ElementsAre(AllOf(StartsWith("run.toml:3: "), HasSubstr("'seed'"), EndsWith("the line is: seed = 2"))));
  EXPECT_THAT(faults_of("[filter]\nalpha = 0,1\n"), ElementsAre(EndsWith("the line is: alpha = 0,1")));
  EXPECT_THAT(faults_of("gr\u00f6\u00dfe = 1\n"), ElementsAre(EndsWith("the line is: gr\u00f6\u00dfe = 1")));
  EXPECT_THAT(faults_of(std::string(50000, '=')), ElementsAre(Not(HasSubstr(std::string(200, '=')))));
}

// The TOML library takes some of these characters for impossible where it looks for blanks.
TEST(ConfigText, CharactersBeyondAsciiBelongIntoQuotes) {
  const std::string why = "not valid TOML: a character beyond ASCII that is not in quotes; the line is: ";
  for (const char* text :
       {"gr\u00f6\u00dfe = 1", "a = \u00e9", "a = [1,\u3001 2]", "[\ufb01]", "a = 1 \u00a1", "a = 1\u2009"}) {
    EXPECT_THAT(faults_of("\n" + std::string(text) + "\n"), ElementsAre("run.toml:2: " + why + text)) << text;
  }
  for (const char* text : {"a = \"\"\"\\\n  \u00e9\"\"\"\n", "a = \"\"\"\\\u00e9\"\"\"\n"}) {
    EXPECT_THAT(faults_of(text), ElementsAre(HasSubstr("a character beyond ASCII right after a backslash"))) << text;
  }
  for (const char* text : {"# \u00e9\n", "[\"\u00e9\"]\n", "['\u00e9']\n", "a = \"\"\"\u00e9\\\n  e\u00e9\"\"\"\n",
                           "a = '''\\\n\u00e9'''\n"}) {
    EXPECT_THAT(faults_of(text), Contains(HasSubstr("texture: missing"))) << text;
  }
  EXPECT_THAT(faults_of("# a\n# \xe9\n"), ElementsAre("run.toml:2: not valid TOML: not text in UTF-8"));
}

TEST(ConfigText, KeysBeyondAsciiAreNamed) {
  EXPECT_THAT(faults_of(ConfigText{}.text() + "\"gr\u00f6\u00dfe\" = 1\n"),
              ElementsAre(HasSubstr("optimizer.\"gr\u00f6\u00dfe\": unknown key")));
  ConfigText config;
  config.second = "{ axes = \"\u00e9\", kernel = \"ema\" , alpha = 1 }";
  EXPECT_THAT(faults_of(config.text()), ElementsAre(HasSubstr("no axis \"\u00e9\"; the texture has x, y, t")));
}

// Each numeric setting with the line that holds it and what it needs beside it.
struct NumericKey {
  std::string key;
  std::vector<std::string> set;
  bool whole = false;  // an integer
};

const std::vector<NumericKey>& numeric_keys() {
  static const std::vector<NumericKey> keys = {
      {"texture.size.x", {}, true},
      {"texture.size.t", {}, true},
      {"texture.seed", {}, true},
      {"filter.groups[0].size", {}, true},
      {"filter.groups[0].sigma", {"filter.groups[0]={ axes = 'xy', kernel = 'gauss' }"}},
      {"filter.groups[0].n", {"filter.groups[0]={ axes = 'xy', kernel = 'binomial' }"}, true},
      {"filter.groups[1].alpha", {}},
      {"filter.groups[1].rejection", {}},
      {"filter.groups[0].weight", {"filter.combine=sum", "filter.groups[1].weight=0.5"}},
      {"energy.sigma_s", {"energy.value_kernel=stbn"}},
      {"optimizer.stop.iterations", {}, true},
      {"optimizer.stop.time", {}},
      {"optimizer.stop.score", {}},
      {"optimizer.stop.improvement", {}},
      {"optimizer.cutoff", {}},
      {"optimizer.background_features", {}, true},
      {"optimizer.sieve_features", {}, true},
      {"optimizer.temperature.start", {}},
      {"optimizer.temperature.end", {}},
      {"optimizer.fraction", {"optimizer.method=fast"}}};
  return keys;
}

std::vector<std::string> faults_with(const NumericKey& number, const std::string& value) {
  std::vector<std::string> overrides = number.set;
  overrides.push_back(number.key + "=" + value);
  return faults_of(ConfigText{}.text(), overrides);
}

TEST(ConfigNumbers, NotFiniteOnesAreRefused) {
  for (const NumericKey& number : numeric_keys()) {
    for (const char* value : {"nan", "inf", "-inf", "+nan"}) {
      EXPECT_THAT(faults_with(number, value), Contains(AllOf(HasSubstr(number.key + " = "), HasSubstr(": must be "))))
          << number.key << value;
    }
    EXPECT_THAT(faults_with(number, "1e400"), ElementsAre(HasSubstr("1e400"))) << number.key;
  }
}

TEST(ConfigNumbers, DenormalOnesAreRefused) {
  for (const NumericKey& number : numeric_keys()) {
    for (const char* value : {"5e-324", "1e-310", "2e-308"}) {
      EXPECT_THAT(faults_with(number, value), Contains(HasSubstr(number.key + " = "))) << number.key << value;
    }
  }
  EXPECT_THAT(faults_of(ConfigText{}.text(), {"filter.groups[1].alpha=1e-310"}),
              ElementsAre(EndsWith("filter.groups[1].alpha = 1e-310: too near to 0: smaller than 2.23e-308")));
}

TEST(ConfigNumbers, IntegersOfAnySizeAreExactOrRefused) {
  EXPECT_EQ(parsed(ConfigText{}.text(), {"texture.seed=9007199254740993"}).problem.seed, 9007199254740993U);
  EXPECT_EQ(parsed(ConfigText{}.text(), {"texture.seed=9223372036854775807"}).problem.seed, 9223372036854775807U);
  for (const NumericKey& number : numeric_keys()) {
    for (const std::string value : {"-9223372036854775808", "9223372036854775808", "-9223372036854775809"}) {
      if (number.key == "optimizer.stop.time" && value.front() != '-') continue;  // a duration as text
      EXPECT_THAT(faults_with(number, value), Contains(HasSubstr(number.key))) << number.key << value;
    }
    if (number.whole && number.key != "texture.seed") {
      EXPECT_THAT(faults_with(number, "9223372036854775807"), Contains(HasSubstr(number.key + " = "))) << number.key;
      EXPECT_THAT(faults_with(number, "9007199254740993"), Contains(HasSubstr(number.key + " = "))) << number.key;
    }
  }
}

TEST(ConfigNumbers, DurationsOfAnyLengthRoundTrip) {
  for (const char* time : {"2.3e-308", "1e-10", "0.1", "1e300", "'0.00000000000001s'", "'99999999999999999999d'"}) {
    const RunConfig config = parsed(ConfigText{}.text(), {std::string("optimizer.stop.time=") + time});
    const RunConfig again = parsed(to_toml(config));
    EXPECT_EQ(again.optimizer.stop.time_s, config.optimizer.stop.time_s) << time;
    EXPECT_GT(again.optimizer.stop.time_s, 0);
  }
  const std::string endless = "optimizer.stop.time='" + std::string(308, '9') + "d'";
  EXPECT_THAT(faults_of(ConfigText{}.text(), {endless}), ElementsAre(EndsWith("must be finite")));
}

// Digits grouped by dots and a decimal comma, as a program that embeds this one may have set it.
class Comma : public std::numpunct<char> {
  char do_decimal_point() const override { return ','; }
  char do_thousands_sep() const override { return '.'; }
  std::string do_grouping() const override { return "\3"; }
};

TEST(ConfigNumbers, AreTheSameUnderEveryLocale) {
  ConfigText config;
  config.seed = "seed = 1234567";
  config.second = "{ axes = \"t\", kernel = \"ema\", alpha = 0.125, rejection = 1e-3 }";
  config.optimizer = "stop = { time = \"1.5s\" }\ncutoff = 0.25";
  const std::string text = to_toml(parsed(config.text(), {"optimizer.temperature.end=0.5"}));
  config.energy = "value_kernel = 1979-05-27";
  const auto faults = faults_of(config.text());
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const char* const c_before = std::setlocale(LC_NUMERIC, nullptr);
  const std::string c_name = c_before == nullptr ? "C" : c_before;
  for (const char* name : {"de_DE.UTF-8", "fr_FR.UTF-8", "de_DE", "ru_RU.UTF-8"}) {
    if (std::setlocale(LC_NUMERIC, name) != nullptr) break;  // not every machine has one
  }
  EXPECT_EQ(to_toml(parsed(text)), text);
  EXPECT_EQ(faults_of(config.text()), faults);
  std::setlocale(LC_NUMERIC, c_name.c_str());
  std::locale::global(before);
  EXPECT_THAT(faults, ElementsAre(HasSubstr("1979-05-27")));
}

}  // namespace
}  // namespace noiseloom
