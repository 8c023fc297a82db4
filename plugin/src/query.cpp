#include "softcd/query.hpp"

#include <utility>

#include "query_core.hpp"
#include "softcd/fields/options.hpp"

bool softcd::operator==(const QueryOptions& a, const QueryOptions& b) {
  return has_equal_fields(a, b);
}

namespace softcd {

Ticket::Ticket(std::shared_ptr<detail::QueryCore> query, std::uint64_t number)
    : query_(std::move(query)), number_(number) {}
Ticket::Ticket(Ticket&&) noexcept = default;
Ticket& Ticket::operator=(Ticket&&) noexcept = default;
Ticket::~Ticket() = default;

Span<const Contact> Ticket::wait() {
  if (query_ == nullptr) throw Error("this Ticket was moved from; wait for the one that it was moved to.");
  return query_->wait(number_);
}
DeviceContacts Ticket::wait_on_device() {
  if (query_ == nullptr) throw Error("this Ticket was moved from; wait for the one that it was moved to.");
  return query_->wait_on_device(number_);
}
PendingContacts Ticket::on_device() {
  if (query_ == nullptr) throw Error("this Ticket was moved from; ask the one that it was moved to.");
  return query_->on_device(number_);
}

Query::Query(Scene& scene, const QueryOptions& options)
    : core_(guarded([] { return detail::kNoMemoryAtAll; },
                    [&] { return std::make_shared<detail::QueryCore>(scene.shared_core(), options); })) {}
Query::Query(Query&&) noexcept = default;
Query::~Query() {
  if (core_ != nullptr) core_->close();
}
Query& Query::operator=(Query&& other) noexcept {
  Query taken(std::move(other));
  std::swap(core_, taken.core_);
  return *this;
}

detail::QueryCore& Query::core() const {
  if (core_ == nullptr) {
    throw Error("this Query was moved from; assign one to it, or use the one that it was moved to.");
  }
  return *core_;
}

Ticket Query::start(Pairs pairs) {
  const std::uint64_t number = core().start(pairs);
  return {core_, number};
}
Span<const Contact> Query::detect(Pairs pairs) {
  return core().wait(core().start(pairs));
}
DeviceContacts Query::detect_on_device(Pairs pairs) {
  return core().wait_on_device(core().start(pairs));
}
void Query::set_options(const QueryOptions& options) {
  core().set_options(options);
}
const QueryOptions& Query::options() const {
  return core().options();
}
void Query::set_only_pairs(Span<const BodyPair> pairs) {
  core().set_only_pairs(pairs);
}
void Query::set_pair_filter(PairFilter filter) {
  core().set_pair_filter(std::move(filter));
}
std::shared_ptr<const void> Query::hold_contacts() {
  return core().hold_contacts();
}
std::vector<Contact> Query::gather_contacts() {
  return core().gather_contacts();
}
const Statistics& Query::statistics() const {
  return core().statistics();
}
std::vector<StageReport> Query::explain() const {
  return core().explain();
}

}  // namespace softcd
