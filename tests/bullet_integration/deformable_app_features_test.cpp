// Features of Bullet's deformable world other than contacts between soft bodies: they work as with Bullet alone.

#include <gtest/gtest.h>

#include <tuple>

#include "BulletCollision/CollisionShapes/btBoxShape.h"
#include "BulletDynamics/Featherstone/btMultiBody.h"
#include "BulletDynamics/Featherstone/btMultiBodyLinkCollider.h"
#include "deformable_app_support.hpp"
#pragma GCC diagnostic push
#ifndef __clang__
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
#include "BulletSoftBody/BulletReducedDeformableBody/btReducedDeformableBody.h"
#include "BulletSoftBody/BulletReducedDeformableBody/btReducedDeformableBodySolver.h"
#pragma GCC diagnostic pop
#include "BulletSoftBody/btSoftBodyHelpers.h"
#include "small_scenes.hpp"
#include "world_outputs.hpp"

namespace softcd::test {
namespace {

using demo::DeformableSimulation;
using Flags = btSoftBody::fCollision;

void add_ground(DeformableSimulation& simulation, btScalar top) {
  simulation.add_rigid(std::make_unique<btBoxShape>(btVector3(2, 1, 2)), btVector3(0, top - 1, 0));
}

/// The places of nodes and faces in contact with rigid bodies.
std::pair<std::multiset<long>, std::multiset<long>> rigid_contacts(const btSoftBody& body) {
  std::multiset<long> nodes;
  std::multiset<long> faces;
  for (int i = 0; i < body.m_nodeRigidContacts.size(); ++i) {
    nodes.insert(body.m_nodeRigidContacts[i].m_node - &body.m_nodes[0]);
  }
  for (int i = 0; i < body.m_faceRigidContacts.size(); ++i) {
    faces.insert(body.m_faceRigidContacts[i].m_face - &body.m_faces[0]);
  }
  return {nodes, faces};
}

TEST(DeformableAppFeatures, nodes_and_faces_touch_a_box_as_with_bullet_whatever_happens_to_the_mesh) {
  const auto run = [](const MaybeSettings& settings) {
    HeldSheets sheets(settings);
    sheets.simulation().add_rigid(std::make_unique<btBoxShape>(btVector3(btScalar(0.3), 1, btScalar(0.2))),
                                  btVector3(btScalar(0.1), btScalar(-0.99), 0));
    btSoftBody& sheet = sheets.add(0);
    sheet.m_cfg.collisions |= Flags::SDF_RDF;
    std::vector<std::pair<std::multiset<long>, std::multiset<long>>> contacts;
    const auto step = [&] {
      sheets.step();
      contacts.push_back(rigid_contacts(sheet));
    };
    step();
    step();
    const int added = sheet.m_nodes.size();
    sheet.appendNode(btVector3(btScalar(0.05), 0, btScalar(0.06)), 1);
    sheet.appendFace(40, 41, added);
    for (const int node : {40, 41}) sheet.appendLink(node, added);
    sheets.hold(sheet);
    step();
    sheet.m_cfg.collisions &= ~Flags::SDF_RDF;
    step();
    sheet.m_cfg.collisions |= Flags::SDF_RDF;
    step();
    return contacts;
  };
  const auto ours = run(cpu_settings());
  EXPECT_EQ(ours, run(std::nullopt));
  EXPECT_GT(ours[0].first.size(), 5U);
  EXPECT_GT(ours[0].second.size(), 5U);
  EXPECT_GT(ours[2].second.size(), ours[0].second.size());
  EXPECT_EQ(ours[3].second.size(), 0U);
  EXPECT_EQ(ours[4], ours[2]);
}

TEST(DeformableAppFeatures, anchors_hold_as_with_bullet) {
  const auto run = [](const MaybeSettings& settings) {
    DeformableSimulation simulation(settings);
    btSoftBody& cloth = simulation.add(make_small_sheet(simulation.world_info(), 0));
    const btVector3 half(btScalar(0.05), btScalar(0.05), btScalar(0.05));
    btRigidBody& moved = simulation.add_rigid(std::make_unique<btBoxShape>(half), cloth.m_nodes[0].m_x);
    moved.setCollisionFlags(btCollisionObject::CF_KINEMATIC_OBJECT);
    moved.setActivationState(DISABLE_DEACTIVATION);
    btRigidBody& hanging = simulation.add_rigid(std::make_unique<btBoxShape>(half), cloth.m_nodes[80].m_x, 1);
    cloth.appendDeformableAnchor(0, &moved);
    cloth.appendDeformableAnchor(80, &hanging);
    for (int step = 0; step < 40; ++step) {
      moved.getWorldTransform().getOrigin().setX(moved.getWorldTransform().getOrigin().x() - kShortStep);
      simulation.step(kShortStep);
    }
    EXPECT_LT(cloth.m_nodes[0].m_x.distance(moved.getWorldTransform().getOrigin()), 1e-3);
    EXPECT_LT(cloth.m_nodes[80].m_x.distance(hanging.getWorldTransform().getOrigin()), 1e-3);
    std::vector<btScalar> result = coordinates_of(cloth);
    for (int axis = 0; axis < 3; ++axis) result.push_back(hanging.getWorldTransform().getOrigin()[axis]);
    return result;
  };
  const std::vector<btScalar> ours = run(cpu_settings());
  const std::vector<btScalar> bullets = run(std::nullopt);
  for (std::size_t i = 0; i < ours.size(); ++i) EXPECT_NEAR(double(ours[i]), double(bullets[i]), 0.01);
}

/// The corners of one of the six tetrahedra of a cube, as bits (x, y, z).
constexpr std::array<std::array<int, 4>, 6> kCubesTetras = {
    {{0, 1, 3, 7}, {0, 3, 2, 7}, {0, 2, 6, 7}, {0, 6, 4, 7}, {0, 4, 5, 7}, {0, 5, 1, 7}}};

/// Eight cubes of tetrahedra, 0.2 wide.
template <class Body>
std::unique_ptr<Body> make_block(btSoftBodyWorldInfo& info, const btVector3& center) {
  std::vector<btVector3> x;
  for (int i = 0; i < 27; ++i) {
    const int row = i / 3 % 3;
    const int layer = i / 9;
    x.push_back(center + btVector3(btScalar(i % 3 - 1), btScalar(row - 1), btScalar(layer - 1)) / 10);
  }
  auto body = std::make_unique<Body>(&info, 27, x.data(), nullptr);
  for (int cube = 0; cube < 8; ++cube) {
    const auto node = [&](int bits) {
      const int corner = cube % 2 + 3 * (cube / 2 % 2) + 9 * (cube / 4);
      return corner + bits % 2 + 3 * (bits / 2 % 2) + 9 * (bits / 4);
    };
    for (const auto& tetra : kCubesTetras) {
      body->appendTetra(node(tetra[0]), node(tetra[1]), node(tetra[2]), node(tetra[3]));
      for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < i; ++j) {
          body->appendLink(node(tetra[static_cast<std::size_t>(i)]), node(tetra[static_cast<std::size_t>(j)]), nullptr,
                           /*bcheckexist=*/true);
        }
      }
    }
  }
  btSoftBodyHelpers::generateBoundaryFaces(body.get());
  body->initializeDmInverse();
  body->m_tetraScratches.resize(body->m_tetras.size());
  body->m_tetraScratchesTn.resize(body->m_tetras.size());
  body->getCollisionShape()->setMargin(btScalar(0.02));
  return body;
}

using Normals = std::map<std::array<int, 4>, btVector3>;

Normals contact_normals(const btAlignedObjectArray<btSoftBody*>& bodies) {
  Normals normals;
  for (int b = 0; b < 2; ++b) {
    for (int i = 0; i < bodies[b]->m_faceNodeContacts.size(); ++i) {
      const btSoftBody::DeformableFaceNodeContact& contact = bodies[b]->m_faceNodeContacts[i];
      normals[{b, int(contact.m_node - &bodies[b]->m_nodes[0]), 1 - b,
               int(contact.m_face - &bodies[1 - b]->m_faces[0])}] = contact.m_normal;
    }
  }
  return normals;
}

TEST(DeformableAppFeatures, volumes_push_outward_even_what_is_inside) {
  for (const double gap : {0.03, -0.015}) {
    SCOPED_TRACE(gap);
    const auto run = [&](const MaybeSettings& settings) {
      HeldSheets blocks(settings);
      btSoftBodyWorldInfo& info = blocks.simulation().world_info();
      blocks.add(make_block<btSoftBody>(info, btVector3(0, 0, 0)));
      blocks.add(make_block<btSoftBody>(info, btVector3(btScalar(0.033), btScalar(0.2 + gap), btScalar(0.047))));
      blocks.step();
      return contact_normals(blocks.bodies());
    };
    const Normals ours = run(cpu_settings());
    const Normals bullets = run(std::nullopt);
    EXPECT_GT(bullets.size(), 5U);
    for (const auto& [contact, normal] : bullets) {
      const auto found = ours.find(contact);
      ASSERT_NE(found, ours.end());
      EXPECT_LT(found->second.distance(normal), 1e-5);
    }
    for (const auto& [contact, normal] : ours) {
      if (btFabs(normal.y()) > btScalar(0.9)) {
        EXPECT_EQ(normal.y() > 0, contact[0] == 1) << "away from the face's block";
      }
    }
  }
}

/// A block with one mode, in which it stretches along y.
std::unique_ptr<btReducedDeformableBody> make_reduced_block(btSoftBodyWorldInfo& info, const btVector3& center) {
  auto block = make_block<btReducedDeformableBody>(info, center);
  block->setReducedModes(1, 27);
  block->m_modes.resize(1);
  for (int n = 0; n < 27; ++n) {
    for (int axis = 0; axis < 3; ++axis) {
      block->m_modes[0].push_back(axis == 1 ? btScalar(n / 3 % 3 - 1) : btScalar(0));
    }
  }
  block->m_Kr.push_back(400);
  block->m_eigenvalues.push_back(400);
  btReducedDeformableBody::tDenseArray masses;
  masses.resize(27, btScalar(0.04));
  block->setMassProps(masses);
  block->setInertiaProps();
  block->internalInitialization();
  block->m_reducedVelocity[0] = block->m_reducedVelocityBuffer[0] = btScalar(0.2);
  block->setRigidAngularVelocity(btVector3(1, 2, 3));
  return block;
}

// Until the first contact: what follows depends on members of Bullet's reduced constraints that it does not initialise.
TEST(DeformableAppFeatures, reduced_bodies_move_and_touch_a_box_exactly_as_with_bullet) {
  const auto run = [](const MaybeSettings& settings) {
    OwnWorld own;
    own.deformable_solver = std::make_unique<btReducedDeformableBodySolver>();
    own.make(settings);
    btBoxShape shape(btVector3(2, 1, 2));
    btRigidBody ground(0, nullptr, &shape);
    ground.getWorldTransform().setOrigin(btVector3(0, -1, 0));
    own.world->addRigidBody(&ground);
    for (const double height : {0.3, 0.7}) {
      own.add(make_reduced_block(own.world->getWorldInfo(), btVector3(0, btScalar(height), 0)));
    }
    std::vector<btScalar> before;
    int steps = 0;
    while (own.bodies[0]->m_nodeRigidContacts.size() == 0 && steps++ < 100) {
      before.clear();
      for (const auto& body : own.bodies) append(before, coordinates_of(*body));
      own.world->stepSimulation(kShortStep, 0);
    }
    own.world->removeRigidBody(&ground);
    EXPECT_GT(steps, 10);
    return std::tuple(steps, before, rigid_contacts(*own.bodies[0]));
  };
  EXPECT_EQ(run(cpu_settings()), run(std::nullopt));
}

/// Mean height of the cloth, height of the box, way of the multibody's link.
std::array<btScalar, 3> catch_box_and_link(const MaybeSettings& settings, int flags) {
  DeformableSimulation simulation(settings);
  auto made = make_small_sheet(simulation.world_info(), 0);
  for (int n = 0; n < 81; ++n) {
    if (n % 9 == 0 || n % 9 == 8) made->setMass(n, 0);
  }
  btSoftBody& cloth = simulation.add(std::move(made));
  cloth.m_cfg.collisions |= flags;
  const btVector3 half(btScalar(0.1), btScalar(0.05), btScalar(0.1));
  btRigidBody& box = simulation.add_rigid(std::make_unique<btBoxShape>(half),
                                          btVector3(0, btScalar(0.1), btScalar(-0.25)), btScalar(0.2));
  box.setLinearVelocity(btVector3(0, -2, 0));
  // A fixed base, and a link that slides down from it.
  btBoxShape shape(half);
  btVector3 inertia;
  shape.calculateLocalInertia(btScalar(0.2), inertia);
  btMultiBody slider(1, 0, btVector3(0, 0, 0), /*fixedBase=*/true, /*canSleep=*/false);
  slider.setBasePos(btVector3(0, btScalar(0.6), btScalar(0.25)));
  slider.setupPrismatic(0, btScalar(0.2), inertia, -1, btQuaternion::getIdentity(), btVector3(0, 1, 0),
                        btVector3(0, btScalar(-0.5), 0), btVector3(0, 0, 0), /*disableParentCollision=*/true);
  slider.finalizeMultiDof();
  btMultiBodyLinkCollider collider(&slider, 0);
  collider.setCollisionShape(&shape);
  btTransform pose = btTransform::getIdentity();
  pose.setOrigin(btVector3(0, btScalar(0.1), btScalar(0.25)));
  collider.setWorldTransform(pose);
  slider.getLink(0).m_collider = &collider;
  simulation.world().addCollisionObject(&collider);
  simulation.world().addMultiBody(&slider);
  slider.setJointVel(0, -2);
  int contacts = 0;
  int face_contacts = 0;
  for (int step = 0; step < 60; ++step) {
    simulation.step(kShortStep);
    contacts += cloth.m_nodeRigidContacts.size();
    face_contacts += cloth.m_faceRigidContacts.size();
  }
  EXPECT_GT(contacts + face_contacts, 10);
  EXPECT_EQ(face_contacts > 0, flags != 0);
  const std::array<btScalar, 3> result = {mean_height(cloth), box.getWorldTransform().getOrigin().y(),
                                          slider.getJointPos(0)};
  simulation.world().removeMultiBody(&slider);
  simulation.world().removeCollisionObject(&collider);
  return result;
}

TEST(DeformableAppFeatures, a_cloth_catches_a_box_and_a_multibody_as_with_bullet) {
  for (const int flags : {0, Flags::SDF_RDF | Flags::SDF_MDF, int(Flags::SDF_MDF)}) {
    const auto ours = catch_box_and_link(cpu_settings(), flags);
    const auto bullets = catch_box_and_link(std::nullopt, flags);
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(double(ours[i]), double(bullets[i]), 0.01);
    EXPECT_GT(ours[1], btScalar(-0.6)) << "it would have fallen by 0.8";
  }
}

/// Whether a ray almost within each face meets the body where that face is.
int count_hit_faces(btSoftBody& body) {
  int hits = 0;
  for (int f = 0; f < body.m_faces.size(); ++f) {
    const btSoftBody::Face& face = body.m_faces[f];
    const btVector3 center = (face.m_n[0]->m_x + face.m_n[1]->m_x + face.m_n[2]->m_x) / 3;
    const btVector3 along = (face.m_n[1]->m_x - face.m_n[0]->m_x) / 10;
    const btVector3 normal = along.cross(face.m_n[2]->m_x - face.m_n[0]->m_x).normalized() / 1000;
    btSoftBody::sRayCast hit;
    hits += body.rayTest(center + along + normal, center - along - normal, hit) && hit.index == f;
  }
  return hits;
}

TEST(DeformableAppFeatures, rays_hit_new_faces_after_a_step) {
  const auto hits = [](const MaybeSettings& settings) {
    HeldSheets sheets(settings);
    btSoftBody& sheet = sheets.add(0);
    sheets.step();
    EXPECT_EQ(count_hit_faces(sheet), 128);
    sheet.appendNode(btVector3(0, btScalar(0.2), 0), 1);
    sheet.appendFace(40, 41, 81);
    sheet.appendLink(40, 81);
    sheets.hold(sheet);
    sheets.step();
    return count_hit_faces(sheet);
  };
  EXPECT_EQ(hits(cpu_settings()), 129);
  EXPECT_EQ(hits(std::nullopt), 129);
}

/// A cloth that falls fast onto one at rest, with a ray test after every step.
std::vector<int> hits_of_falling_cloth(const MaybeSettings& settings, bool is_implicit) {
  DeformableSimulation simulation(settings);
  simulation.world().setImplicit(is_implicit);
  simulation.world().setUseProjection(is_implicit);
  btSoftBody& rests = simulation.add(make_small_sheet(simulation.world_info(), 0));
  btSoftBody& falls = simulation.add(make_small_sheet(simulation.world_info(), btScalar(0.37)));
  falls.setVelocity(btVector3(0, -20, 0));
  std::vector<int> hits;
  for (int step = 0; step < 6; ++step) {
    simulation.step(kStep);
    hits.push_back(count_hit_faces(rests));
    hits.push_back(count_hit_faces(falls));
  }
  return hits;
}

TEST(DeformableAppFeatures, rays_hit_every_face_where_it_is) {
  for (const bool is_implicit : {false, true}) {
    const std::vector<int> all(12, 128);
    EXPECT_EQ(hits_of_falling_cloth(std::nullopt, is_implicit), all) << "Bullet";
    EXPECT_EQ(hits_of_falling_cloth(cpu_settings(), is_implicit), all) << "implicit: " << is_implicit;
  }
}

/// Everything that the world draws and saves: sheets in contact, tetrahedra, an anchor, a rigid body.
struct Exhibition {
  TwoHeldSheets sheets;

  explicit Exhibition(const MaybeSettings& settings) : sheets(settings) {
    DeformableSimulation& simulation = sheets.simulation();
    add_ground(simulation, btScalar(-0.5));
    simulation.add(make_block<btSoftBody>(simulation.world_info(), btVector3(2, 0, 0)));
    sheets.lower.appendNote("note", btVector3(0, 0, 0), &sheets.lower.m_nodes[0]);
    sheets.upper.setMass(0, 0);
    for (int i = 0; i < 2; ++i) EXPECT_FALSE(sheets.step().empty());
  }
  btDeformableMultiBodyDynamicsWorld& world() { return sheets.simulation().world(); }
};

TEST(DeformableAppFeatures, worlds_are_saved_as_bullets_are) {
  Exhibition ours(cpu_settings());
  Exhibition bullets(std::nullopt);
  const auto chunks = save(ours.world()).chunks;
  EXPECT_EQ(chunks, save(bullets.world()).chunks);
  EXPECT_FALSE(chunks.empty());
}

// softcd builds no face trees of Bullet's.
TEST(DeformableAppFeatures, worlds_are_drawn_as_bullets_are_but_for_face_trees) {
  Exhibition ours(cpu_settings());
  Exhibition bullets(std::nullopt);
  const auto lines = [](Exhibition& exhibition, int flags) {
    exhibition.world().setDrawFlags(flags);
    return lines_drawn(exhibition.world());
  };
  const int nothing = lines(ours, 0);
  for (int flag = fDrawFlags::Nodes; flag <= fDrawFlags::Joints; flag *= 2) {
    SCOPED_TRACE(flag);
    if (flag == fDrawFlags::FaceTree) {
      EXPECT_EQ(lines(ours, flag), nothing);
    } else {
      EXPECT_EQ(lines(ours, flag), lines(bullets, flag));
    }
  }
  EXPECT_GT(lines(ours, fDrawFlags::Faces | fDrawFlags::Tetras), nothing);
  EXPECT_GT(lines(ours, -1), nothing);
}

}  // namespace
}  // namespace softcd::test
