// Random numbers that a seed determines on every machine: the standard fixes the engine's, but no distribution's.
#pragma once

#include <cstdint>
#include <random>

namespace humanoid_rail {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  // From 0 to below 1.
  [[nodiscard]] double share() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  [[nodiscard]] double between(double low, double high) { return low + share() * (high - low); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace humanoid_rail
