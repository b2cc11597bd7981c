// Whether textures that were made with different seeds are independent of each other, and alike in distribution.
//
// Correlation: over the whole torus of two members a and b, for every shift d of one against the other,
//
//   r_ab(d) = sum_k A(k) conj(B(k)) exp(2 pi i k d) / sqrt(sum |A|^2 sum |B|^2)        k other than 0, summed over
//   channels
//
// A shift finds what was made from one stream of random numbers read at another place. Of independent members the
// phases are, so r has the mean 0 and the variance sum |A|^2 |B|^2 / (sum |A|^2 sum |B|^2), which is 1 / N for white
// noise and more for blue noise; as a sum of many it is normal. The same over the frequencies of a band, without a
// shift, is the band's cross spectrum. `odds` is how likely independent members would have a value as large anywhere
// among all that were looked at: at most the sum of their tails.
//
// Distribution: Kolmogorov's distance of a member's values from those of all members with the same settings, against
// the bound of Dvoretzky, Kiefer and Wolfowitz (measure/distribution.h), and the logarithm of its power in each band
// against that of the others (Student's t).
//
// A fault is what chance makes with odds below one in a million.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "noiseloom/core/parallel.h"
#include "noiseloom/measure/verify.h"

namespace noiseloom {

struct MemberFile {
  std::string name;
  std::string path;      // a run file
  std::string checksum;  // of /samples
  std::string settings;  // but for the seed: members of other settings differ in distribution
};

struct LargestCorrelation {
  double value = 0;       // r
  double deviations = 0;  // |r| over its standard deviation
  double odds = 1;
  std::string where;  // "seed1 and seed2", with the shift or the band
};

struct MembersVerification {
  std::size_t members = 0;
  std::size_t compared = 0;  // in pairs: all, or as many evenly spread ones as take bounded time
  std::int64_t pairs = 0;
  LargestCorrelation unshifted;
  LargestCorrelation shifted;
  struct Band {
    double first = 0;  // cycles a pixel over x and y
    double last = 0;
    double power = 0;  // mean over members; white noise: 1
    LargestCorrelation largest;
  };
  std::vector<Band> bands;
  double distance = 0;  // the largest over its bound: at most 1 where the distributions are alike
  std::vector<Finding> findings;

  bool is_sound() const { return findings.empty(); }
};

// Pairs are of members with the same size and channels. Throws UserError where there are fewer than two members, and as
// load_stored_texture does.
MembersVerification verify_members(const std::vector<MemberFile>& members, ThreadPool& pool);

std::string members_text(const MembersVerification& found, const std::string& name);
std::string members_json(const MembersVerification& found, const std::string& name);

}  // namespace noiseloom
