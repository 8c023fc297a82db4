// Steps at rest take no new memory for the contacts that are solved once more.

#include <gtest/gtest.h>

#include "any_simulation.hpp"
#include "failing_allocations.hpp"
#include "native/arrays.hpp"
#include "read_out/late_contacts.hpp"
#include "soft_body_support.hpp"

namespace softcd::test {
namespace {

TEST(LateContacts, of_as_many_bodies_and_contacts_need_no_new_memory) {
  AnySimulation simulation(World::one_line, test_settings());
  for (int i = 0; i < 4; ++i) {
    SheetOptions options;
    options.height = btScalar(0.06) * btScalar(i);
    simulation.add(make_sheet(simulation.world_info(), options));
  }
  simulation.step_once();
  const Span<btSoftBody* const> bodies = bullet::span_of(simulation.bodies());
  for (const btSoftBody* body : bodies) ASSERT_GT(body->m_scontacts.size(), 0);

  bullet::LateContacts late;
  late.find(bodies);
  const FailingAllocation failing(1);
  EXPECT_NO_THROW(late.find(bodies));
}

}  // namespace
}  // namespace softcd::test
