#pragma once

#include "softcd/core/host_device.hpp"

namespace softcd {

/// Returns the exact rounding error of the product (Dekker 1971).
SOFTCD_HD inline double product_rest(double a, double b, double product) {
  constexpr double kSplit = 134217729.0;  // 2^27 + 1
  const double a_scaled = kSplit * a;
  const double b_scaled = kSplit * b;
  const double a_high = a_scaled - (a_scaled - a);
  const double b_high = b_scaled - (b_scaled - b);
  const double a_low = a - a_high;
  const double b_low = b - b_high;
  return a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low);
}

/// Returns the exact rounding error of the sum (Knuth 1969).
SOFTCD_HD inline double sum_rest(double a, double b, double sum) {
  const double b_there = sum - a;
  const double a_there = sum - b_there;
  return (a - a_there) + (b - b_there);
}

/// hi + lo, where lo is at most hi's rounding: a number with twice a double's precision.
struct DoubleDouble {
  double hi, lo;
};

SOFTCD_HD inline DoubleDouble exact_product(double a, double b) {
  const double product = a * b;
  return {product, product_rest(a, b, product)};
}

SOFTCD_HD inline DoubleDouble exact_difference(double a, double b) {
  const double difference = a - b;
  return {difference, sum_rest(a, -b, difference)};
}

/// Returns the sum, with an error of at most 2^-103 (|a| + |b|).
SOFTCD_HD inline DoubleDouble operator+(const DoubleDouble& a, const DoubleDouble& b) {
  const double sum = a.hi + b.hi;
  const double rest = sum_rest(a.hi, b.hi, sum) + (a.lo + b.lo);
  const double hi = sum + rest;
  return {hi, rest - (hi - sum)};
}

SOFTCD_HD inline DoubleDouble operator-(const DoubleDouble& a) {
  return {-a.hi, -a.lo};
}

/// Returns the product, with an error of at most 2^-103 |a b|.
SOFTCD_HD inline DoubleDouble operator*(const DoubleDouble& a, const DoubleDouble& b) {
  const double product = a.hi * b.hi;
  const double rest = product_rest(a.hi, b.hi, product) + (a.hi * b.lo + a.lo * b.hi);
  const double hi = product + rest;
  return {hi, rest - (hi - product)};
}

/// A sum without rounding (Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates,
/// 1997). Its parts do not overlap, ascend, and are never 0. Exact unless an added number overflows or underflows.
template <int kMostTerms>
class ExactSum {
 public:
  /// Adds a term. At most kMostTerms terms may be added.
  SOFTCD_HD void add(double term) {
    if (term == 0.0) return;
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      const double sum = term + parts_[i];
      const double rest = sum_rest(term, parts_[i], sum);
      if (rest != 0.0) parts_[kept++] = rest;
      term = sum;
    }
    if (term != 0.0) parts_[kept++] = term;
    count_ = kept;
  }

  /// Returns 1, 0 or -1. The largest part exceeds all others together, so its sign is the sum's.
  SOFTCD_HD int sign() const { return count_ == 0 ? 0 : (parts_[count_ - 1] > 0.0 ? 1 : -1); }

  /// Returns the sum, off by at most two roundings, with the exact sign.
  SOFTCD_HD double value() const {
    double sum = 0.0;
    for (int i = 0; i < count_; ++i) sum += parts_[i];
    return sum;
  }

 private:
  double parts_[kMostTerms];
  int count_ = 0;
};

}  // namespace softcd
