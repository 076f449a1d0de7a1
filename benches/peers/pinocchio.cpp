// Pinocchio: crba and nonLinearEffects on the model built joint by joint.
//
// Both conventions of crba are compiled; CONVENTION selects one of them.
#include "peer.h"
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>

namespace pin = pinocchio;

static pin::Model model;
static pin::Data *data;
static Eigen::VectorXd q, v;

static pin::JointModel joint_model(const peer_joint &joint)
{
    switch (joint.axis + 3 * joint.revolute) {
    case 0: return pin::JointModelPX();
    case 1: return pin::JointModelPY();
    case 2: return pin::JointModelPZ();
    case 3: return pin::JointModelRX();
    case 4: return pin::JointModelRY();
    default: return pin::JointModelRZ();
    }
}

static void build()
{
    model.gravity.linear() = Eigen::Vector3d(peer_gravity);
    for (int i = 0; i < peer_joints; i++) {
        const peer_joint &joint = peer_joint_list[i];
        const pin::SE3 place(Eigen::Matrix3d::Identity(), Eigen::Vector3d(joint.anchor));
        const auto id = model.addJoint((pin::JointIndex)(joint.parent + 1), joint_model(joint), place,
                                       "j" + std::to_string(i + 1));
        const double *I = joint.inertia;
        Eigen::Matrix3d inertia;
        inertia << I[0], I[1], I[2], I[1], I[3], I[4], I[2], I[4], I[5];
        if (joint.mass != 0.0 || inertia.norm() != 0.0)
            model.appendBodyToJoint(id,
                                    pin::Inertia(joint.mass, Eigen::Vector3d(joint.center), inertia),
                                    pin::SE3::Identity());
    }
    data = new pin::Data(model);
    q.resize(model.nq);
    v.resize(model.nv);
}

static void peer_evaluate(int s)
{
    const size_t n = (size_t)peer_joints;
    q = Eigen::Map<const Eigen::VectorXd>(peer_q + s * n, (Eigen::Index)n);
    v = Eigen::Map<const Eigen::VectorXd>(peer_qd + s * n, (Eigen::Index)n);
    pin::crba(model, *data, q, pin::Convention::CONVENTION);
    pin::nonLinearEffects(model, *data, q, v);
}

// Joints keep their numbers: parents come first, and so does Pinocchio count.
static void peer_result(double *M, double *c)
{
    const int n = peer_joints;
    for (int i = 0; i < n; i++) {
        const int row = model.joints[(size_t)i + 1].idx_v();
        c[i] = data->nle[row];
        for (int j = 0; j < n; j++) {
            const int column = model.joints[(size_t)j + 1].idx_v();
            M[i * n + j] = row <= column ? data->M(row, column) : data->M(column, row);
        }
    }
}

int main(int count, char **words)
{
    peer_read(count, words);
    build();
    return peer_main(count, words);
}
