#include "noiseloom/core/json.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

TEST(Json, ReadsTheStringsThatItWrites) {
  const std::string text = "a \"quoted\" \\ line\nnext\ttab \x01 { } [ ] , : \xc3\xa4";
  const auto members =
      parse_json_object("{\"key\": " + json_string(text) + ", \"other\" : [1, [2, 3]] ,\"x\":-1.5e3}", "test");
  EXPECT_EQ(members.at("key"), text);
  EXPECT_EQ(members.at("other"), "[1, [2, 3]]");
  EXPECT_EQ(members.at("x"), "-1.5e3");
  EXPECT_TRUE(parse_json_object(" { } ", "test").empty());
}

TEST(Json, RefusesWhatIsCutShort) {
  for (const char* const text :
       {"", "{", "{\"a\"", "{\"a\": \"b", "{\"a\": 1", "[1]", "{\"a\" 1}", "{\"a\": \"\\u00zz\"}"})
    EXPECT_THROW(parse_json_object(text, "test"), UserError) << text;
}

TEST(Json, WritesObjectsThatItReads) {
  EXPECT_EQ(json_object({}), "{}");
  const std::string text =
      json_object({{"count", std::int64_t{-7}}, {"x", 0.5}, {"none", std::nan("")}, {"a \"b\"", "\n"}});
  EXPECT_EQ(text, "{\"count\": -7, \"x\": 0.5, \"none\": null, \"a \\\"b\\\"\": \"\\n\"}");
  const auto members = parse_json_object(text, "test");
  EXPECT_EQ(members.at("count"), "-7");
  EXPECT_EQ(members.at("a \"b\""), "\n");
}

TEST(Json, WritesNumbersThatReadBackExactly) {
  EXPECT_EQ(std::stod(json_number(0.1 + 0.2)), 0.1 + 0.2);
  EXPECT_EQ(json_number(std::numeric_limits<double>::infinity()), "null");
}

}  // namespace
}  // namespace noiseloom
