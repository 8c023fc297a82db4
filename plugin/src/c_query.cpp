#include <cstddef>

#include "c_fields.hpp"

namespace softcd::c_interface {
namespace {

static_assert(sizeof(softcd_contact) == sizeof(Contact) && alignof(softcd_contact) <= alignof(Contact));
static_assert(offsetof(softcd_contact, is_unsettled) == offsetof(Contact, is_unsettled) &&
              offsetof(softcd_contact, body_a) == offsetof(Contact, body_a) &&
              offsetof(softcd_contact, body_b) == offsetof(Contact, body_b) &&
              offsetof(softcd_contact, feature_a) == offsetof(Contact, feature_a) &&
              offsetof(softcd_contact, feature_b) == offsetof(Contact, feature_b) &&
              offsetof(softcd_contact, vertices) == offsetof(Contact, vertices) &&
              offsetof(softcd_contact, weights) == offsetof(Contact, weights) &&
              offsetof(softcd_contact, normal) == offsetof(Contact, normal) &&
              offsetof(softcd_contact, distance) == offsetof(Contact, distance) &&
              offsetof(softcd_contact, time_of_impact) == offsetof(Contact, time_of_impact));
static_assert(sizeof(softcd_contact_counts) == sizeof(ContactCounts) &&
              offsetof(softcd_contact_counts, is_complete) == offsetof(ContactCounts, is_complete));
static_assert(SOFTCD_NO_BODY == BodyId().value);

const softcd_contact* as_c(const Contact* contacts) {
  return reinterpret_cast<const softcd_contact*>(contacts);
}

void start(softcd_query& query, softcd_pairs pairs) {
  if (pairs > SOFTCD_PAIRS_CHANGED) refuse_choice("pairs", pairs, SOFTCD_PAIRS_CHANGED);
  query.ticket.emplace(query.query.start(static_cast<Pairs>(pairs)));
}

Ticket& started(softcd_query& query) {
  if (!query.ticket.has_value()) throw Error("no detection was started; call softcd_query_start() first.");
  return *query.ticket;
}

}  // namespace
}  // namespace softcd::c_interface

namespace c = softcd::c_interface;

softcd_status softcd_query_options_init(softcd_query_options* options, uint64_t size) {
  return c::initialize(options, size, "options", c::to_c<softcd_query_options>(softcd::QueryOptions()));
}

softcd_status softcd_query_create(softcd_scene* scene, const softcd_query_options* options, softcd_query** query) {
  return c::guarded_call([&] {
    softcd_query*& out = c::result(query, "query");
    out = new softcd_query{
        softcd::Query(c::required(scene, "scene").scene, c::from_c<softcd::QueryOptions>(options, "options")), {}};
  });
}

void softcd_query_destroy(softcd_query* query) {
  delete query;
}

softcd_status softcd_query_set_options(softcd_query* query, const softcd_query_options* options) {
  return c::guarded_call(
      [&] { c::required(query, "query").query.set_options(c::from_c<softcd::QueryOptions>(options, "options")); });
}

softcd_status softcd_query_set_only_pairs(softcd_query* query, const softcd_body_pair* pairs, uint64_t count) {
  return c::guarded_call(
      [&] { c::required(query, "query").query.set_only_pairs(c::elements<softcd::BodyPair>(pairs, count, "pairs")); });
}

softcd_status softcd_query_set_pair_filter(softcd_query* query, softcd_pair_filter filter, void* user_data) {
  return c::guarded_call([&] {
    softcd::PairFilter callback;
    if (filter != nullptr) {
      callback = [filter, user_data](softcd::BodyId a, softcd::BodyId b) {
        return filter(user_data, a.value, b.value) != 0;
      };
    }
    c::required(query, "query").query.set_pair_filter(std::move(callback));
  });
}

softcd_status softcd_query_start(softcd_query* query, softcd_pairs pairs) {
  return c::guarded_call([&] { c::start(c::required(query, "query"), pairs); });
}

softcd_status softcd_query_wait(softcd_query* query, const softcd_contact** contacts, uint64_t* count) {
  return c::guarded_call([&] {
    const softcd_contact*& out = c::result(contacts, "contacts");
    uint64_t& out_count = c::result(count, "count");
    const softcd::Span<const softcd::Contact> found = c::started(c::required(query, "query")).wait();
    out = c::as_c(found.data());
    out_count = found.size();
  });
}

softcd_status softcd_query_wait_on_device(softcd_query* query, softcd_device_contacts* contacts) {
  return c::guarded_call([&] {
    softcd_device_contacts& out = c::sized_result(contacts, "contacts");
    const softcd::DeviceContacts found = c::started(c::required(query, "query")).wait_on_device();
    out.device = found.device;
    out.data = c::as_c(found.data);
    out.count = found.count;
    out.body_begin = found.body_begin;
    out.body_ids = found.body_ids;
  });
}

softcd_status softcd_query_on_device(softcd_query* query, softcd_pending_contacts* contacts) {
  return c::guarded_call([&] {
    softcd_pending_contacts& out = c::sized_result(contacts, "contacts");
    const softcd::PendingContacts found = c::started(c::required(query, "query")).on_device();
    out.device = found.device;
    out.data = c::as_c(found.data);
    out.capacity = found.capacity;
    out.counts = reinterpret_cast<const softcd_contact_counts*>(found.counts);
    out.body_begin = found.body_begin;
    out.body_ids = found.body_ids;
    out.ready = found.ready;
  });
}

softcd_status softcd_query_detect(softcd_query* query, softcd_pairs pairs, const softcd_contact** contacts,
                                  uint64_t* count) {
  return c::guarded_call([&] {
    const softcd_contact*& out = c::result(contacts, "contacts");
    uint64_t& out_count = c::result(count, "count");
    softcd_query& detecting = c::required(query, "query");
    c::start(detecting, pairs);
    const softcd::Span<const softcd::Contact> found = detecting.ticket->wait();
    out = c::as_c(found.data());
    out_count = found.size();
  });
}

softcd_status softcd_query_statistics(const softcd_query* query, softcd_statistics* statistics) {
  return c::guarded_call([&] {
    softcd_statistics& out = c::sized(statistics, "statistics");
    const softcd::Statistics& found = c::required(query, "query").query.statistics();
    out = c::to_c<softcd_statistics>(found);
    out.total_ms = found.ms.total;
  });
}
