#include "noiseloom/core/math.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include "noiseloom/core/random.h"

namespace noiseloom {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr long double pi_l = 3.14159265358979323846264338327950288L;
constexpr int num_points = 200'003;

// Largest value of error(x) over points spread evenly, with random offsets, over [low, high].
double largest_over(double low, double high, const std::function<long double(double)>& error) {
  long double largest = 0;
  for (int i = 0; i < num_points; ++i) {
    const RandomBlock bits = random_block(7, Purpose::jitter, 0, 0, static_cast<std::uint64_t>(i));
    const double x = low + (high - low) * ((i + to_unit_double(bits[0], bits[1])) / num_points);
    largest = std::max(largest, error(std::min(x, high)));
  }
  return static_cast<double>(largest);
}

long double relative(long double found, long double exact) { return std::fabs(found - exact) / std::fabs(exact); }

TEST(MathExp, MatchesLongDoubleOverTheWholeNormalRange) {
  const auto error = [](double x) { return relative(math::exp(x), std::exp(static_cast<long double>(x))); };
  EXPECT_LE(largest_over(-708, 709.78, error), 1e-15);
  EXPECT_LE(largest_over(-1, 1, error), 1e-15);
  EXPECT_LE(largest_over(-1e-9, 1e-9, error), 1e-15);
}

TEST(MathExp, EndsInZeroInfinityAndDenormals) {
  EXPECT_EQ(math::exp(0), 1);
  EXPECT_EQ(math::exp(-0.0), 1);
  EXPECT_EQ(math::exp(-infinity), 0);
  EXPECT_EQ(math::exp(-1000), 0);
  EXPECT_EQ(math::exp(infinity), infinity);
  EXPECT_EQ(math::exp(709.79), infinity);
  EXPECT_TRUE(std::isnan(math::exp(nan)));
  const auto error = [](double x) { return std::fabs(math::exp(x) - std::exp(static_cast<long double>(x))); };
  EXPECT_LE(largest_over(-746, -708, error), 5e-324 + 1e-15 * 3e-308);
}

TEST(MathLog, MatchesLongDoubleForEveryExponent) {
  const auto error = [](double x) { return relative(math::log(x), std::log(static_cast<long double>(x))); };
  EXPECT_LE(largest_over(0.25, 4, error), 1e-15);
  EXPECT_LE(largest_over(1 - 1e-6, 1 + 1e-6, error), 1e-15);
  for (int exponent = -1074; exponent < 1024; ++exponent) {
    for (const double mantissa : {1.0, 1.3, 1.41421356, 1.5, 1.999999}) {
      const double x = std::ldexp(mantissa, exponent);
      ASSERT_LE(x == 1 ? std::fabs(math::log(x)) : error(x), 1e-15) << x;
    }
  }
}

TEST(MathLog, KeepsItsEdges) {
  EXPECT_EQ(math::log(1), 0);
  EXPECT_EQ(math::log(0), -infinity);
  EXPECT_EQ(math::log(infinity), infinity);
  EXPECT_TRUE(std::isnan(math::log(-1)));
  EXPECT_TRUE(std::isnan(math::log(nan)));
}

TEST(MathPow, MatchesLongDoubleWithinItsScaledBound) {
  for (const double exponent : {-2.0, -0.3, 1.0 / 3, 0.5, 2.0 / 3, 1.0, 1.5, 2.0, 8.0, 60.0}) {
    const auto error = [exponent](double x) {
      const long double log_power = exponent * std::log(static_cast<long double>(x));
      return relative(math::pow(x, exponent), std::exp(log_power)) / std::max(1.0L, std::fabs(log_power));
    };
    EXPECT_LE(largest_over(1e-5, 100, error), 1e-14) << exponent;
    EXPECT_LE(largest_over(0.999, 1.001, error), 1e-14) << exponent;
  }
}

TEST(MathPow, KeepsItsEdges) {
  EXPECT_EQ(math::pow(0, 0), 1);
  EXPECT_EQ(math::pow(0, 0.25), 0);
  EXPECT_EQ(math::pow(0, -1), infinity);
  EXPECT_EQ(math::pow(1, 1e300), 1);
  EXPECT_EQ(math::pow(0.3, 1), 0.3);
}

TEST(MathSinCos, MatchLongDoubleForAllTurns) {
  for (const double range : {0.51, 7.0, 0x1p20, 0x1p45}) {
    const auto sin_error = [](double turns) {
      const long double reduced = turns - std::floor(turns);
      return std::fabs(math::sin_2pi(turns) - std::sin(2 * pi_l * reduced));
    };
    const auto cos_error = [](double turns) {
      const long double reduced = turns - std::floor(turns);
      return std::fabs(math::cos_2pi(turns) - std::cos(2 * pi_l * reduced));
    };
    EXPECT_LE(largest_over(-range, range, sin_error), 5e-16);
    EXPECT_LE(largest_over(-range, range, cos_error), 5e-16);
  }
}

TEST(MathSinCos, AreExactAtQuarterTurnsAndFiniteEverywhere) {
  for (int quarter = -9; quarter <= 9; ++quarter) {
    const int sine[] = {0, 1, 0, -1};
    EXPECT_EQ(math::sin_2pi(0.25 * quarter), sine[quarter & 3]);
    EXPECT_EQ(math::cos_2pi(0.25 * quarter), sine[(quarter + 1) & 3]);
  }
  EXPECT_EQ(math::cos_2pi(1e300), 1);
  EXPECT_EQ(math::sin_2pi(0x1p52 + 1), 0);
  EXPECT_TRUE(std::isnan(math::sin_2pi(infinity)));
  EXPECT_TRUE(std::isnan(math::cos_2pi(nan)));
}

TEST(MathAcos, MatchesLongDouble) {
  const auto error = [](double x) { return std::fabs(math::acos(x) - std::acos(static_cast<long double>(x))); };
  EXPECT_LE(largest_over(-1, 1, error), 1e-15);
  EXPECT_LE(largest_over(1 - 1e-6, 1, error), 1e-15);
  EXPECT_LE(largest_over(-1, -1 + 1e-6, error), 1e-15);
  EXPECT_LE(largest_over(0.5 - 1e-9, 0.5 + 1e-9, error), 1e-15);
  EXPECT_LE(largest_over(-1e-9, 1e-9, error), 1e-15);
}

TEST(MathAcos, ClampsAndKeepsItsEdges) {
  EXPECT_EQ(math::acos(1), 0);
  EXPECT_EQ(math::acos(-1), math::pi);
  EXPECT_EQ(math::acos(1 + 1e-7), 0);
  EXPECT_EQ(math::acos(-1e300), math::pi);
  EXPECT_EQ(math::acos(infinity), 0);
  EXPECT_EQ(math::acos(0), 0.5 * math::pi);
  EXPECT_EQ(math::acos(5e-324), 0.5 * math::pi);
  EXPECT_TRUE(std::isnan(math::acos(nan)));
}

TEST(MathErf, MatchesLongDouble) {
  const auto error = [](double x) { return std::fabs(math::erf(x) - std::erf(static_cast<long double>(x))); };
  EXPECT_LE(largest_over(-7, 7, error), 1e-15);
  EXPECT_LE(largest_over(0.99, 1.01, error), 1e-15);
  EXPECT_EQ(math::erf(0), 0);
  EXPECT_EQ(math::erf(infinity), 1);
  EXPECT_EQ(math::erf(-100), -1);
  EXPECT_TRUE(std::isnan(math::erf(nan)));
}

// Relative error of x = found(p): first order in the error of p, whose CDF libm gives with full relative accuracy.
long double quantile_error(double x, long double p) {
  const long double cdf = std::erfc(-x / std::sqrt(2.0L)) / 2;
  const long double density = std::exp(-0.5L * x * x) / std::sqrt(2 * pi_l);
  return std::fabs((cdf - p) / (density * x));
}

TEST(MathInverseNormalCdf, InvertsTheLongDoubleCdf) {
  const auto error = [](double p) { return quantile_error(math::inverse_normal_cdf(p), p); };
  EXPECT_LE(largest_over(1e-6, 0.499, error), 1e-13);
  for (double p = 0.499; p > 1e-300; p *= 0.97) ASSERT_LE(error(p), 1e-13) << p;
  for (const double p : {5e-324, 1e-310, 2.2e-308}) ASSERT_LE(error(p), 1e-13) << p;
}

TEST(MathInverseNormalCdf, IsOddAboutOneHalfAndRises) {
  double previous = -infinity;
  for (int i = 1; i < 4096; ++i) {
    const double p = i / 4096.0;
    EXPECT_EQ(math::inverse_normal_cdf(p), -math::inverse_normal_cdf(1 - p));
    EXPECT_LT(previous, math::inverse_normal_cdf(p));
    previous = math::inverse_normal_cdf(p);
  }
  EXPECT_EQ(math::inverse_normal_cdf(0.5), 0);
  EXPECT_EQ(math::inverse_normal_cdf(0), -infinity);
  EXPECT_EQ(math::inverse_normal_cdf(1), infinity);
  EXPECT_TRUE(std::isnan(math::inverse_normal_cdf(1.5)));
  EXPECT_TRUE(std::isnan(math::inverse_normal_cdf(nan)));
}

// FNV-1a over the bits of every function's results: other bits mean other textures, so a change is a change of format.
TEST(Math, GivesTheSameBitsOnEveryMachine) {
  std::uint64_t digest = 0xcbf29ce484222325U;
  const auto add = [&digest](double value) {
    digest = (digest ^ std::bit_cast<std::uint64_t>(value)) * 0x100000001b3U;
  };
  for (std::uint64_t i = 0; i < 10'007; ++i) {
    const RandomBlock bits = random_block(3, Purpose::jitter, 0, 0, i);
    const double u = to_unit_double(bits[0], bits[1]);
    const double v = to_unit_double(bits[2], bits[3]);
    add(math::exp(40 * u - 20));
    add(math::log(u + 1e-300));
    add(math::pow(10 * u, 3 * v));
    add(math::sin_2pi(5 * u - v));
    add(math::cos_2pi(5 * u - v));
    add(math::acos(2 * u - 1));
    add(math::erf(8 * v - 4));
    add(math::inverse_normal_cdf(v * u + 1e-30));
  }
  EXPECT_EQ(digest, 7499570542926604442U);
}

}  // namespace
}  // namespace noiseloom
