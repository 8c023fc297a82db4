#include "impulse_sums.hpp"

#include <utility>

#include "body_ids.hpp"
#include "bytes.hpp"

namespace softcd::bullet::pybullet {
namespace {

/// Has the members of python/softcd/_bullet_contacts.py.
struct SumRecord {
  std::array<std::int32_t, 4> ids;
  std::array<double, 3> on_a, on_b;
};
static_assert(sizeof(SumRecord) == 64);

}  // namespace

void ImpulseSums::add(const std::vector<BodyPairContacts>& pairs, double step_length) noexcept {
  seconds_ += step_length;
  try {
    for (const BodyPairContacts& pair : pairs) {
      if (pair.state != BodyPairContacts::State::ended) add_pair(pair);
    }
  } catch (...) {
    has_failed_ = true;
  }
}

void ImpulseSums::add_pair(const BodyPairContacts& pair) {
  const ObjectIds a = ids_of(pair.a);
  const ObjectIds b = ids_of(pair.b);
  Sum& sum = sums_[{a.body, a.link, b.body, b.link}];
  for (int i = 0; i < 3; ++i) {
    const auto axis = static_cast<std::size_t>(i);
    sum.on_a[axis] += pair.has_impulses ? pair.impulse_a[i] : kUnknown;
    sum.on_b[axis] += pair.has_impulses ? pair.impulse_b[i] : kUnknown;
  }
}

std::string ImpulseSums::take() {
  std::vector<SumRecord> records;
  for (const auto& [ids, sum] : sums_) {
    records.push_back({ids, sum.on_a, sum.on_b});
    if (!has_failed_) continue;
    records.back().on_a.fill(kUnknown);
    records.back().on_b.fill(kUnknown);
  }
  const std::array<double, 1> seconds = {seconds_};
  *this = {};
  return bytes_of(seconds) + bytes_of(records);
}

}  // namespace softcd::bullet::pybullet
