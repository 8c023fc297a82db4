#include "worlds/world_kind.hpp"

namespace softcd::bullet {

const WorldKind kClassicWorld = {
    .contacts = kClassicContacts,
    .crossings = kClassicCrossings,
    .tree_flag = kClassicTreeFlag,
    .ray_targets = RayTargets::faces_and_tetrahedra,
    .automatic_edge_contacts = EdgeContacts::off,
    .moves_rigid_bodies_first = true,
    .read_contacts = &ContactReader::read_classic,
    .detect_natively = detect_classic_contacts,
};

const WorldKind kDeformableWorld = {
    .contacts = kDeformableContacts,
    .crossings = kDeformableCrossings,
    .tree_flag = kDeformableTreeFlag,
    .ray_targets = RayTargets::faces,
    .automatic_edge_contacts = EdgeContacts::respond,
    .moves_rigid_bodies_first = false,
    .read_contacts = &ContactReader::read_deformable,
    .detect_natively = detect_deformable_contacts,
};

}  // namespace softcd::bullet
