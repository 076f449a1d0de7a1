// Pinocchio: crba and nonLinearEffects, rnea, aba, or the derivatives of the last
// two, on the model built joint by joint.
//
// Of crba and aba both conventions are compiled; CONVENTION selects one of
// them.
#include "peer.h"
#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>
#include <pinocchio/multibody.hpp>

namespace pin = pinocchio;

static pin::Model model;
static pin::Data *data;
static Eigen::VectorXd q, v, given;
static pin::container::aligned_vector<pin::Force> loads;

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
        const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> turn(joint.turn);
        const pin::SE3 place(Eigen::Matrix3d(turn), Eigen::Vector3d(joint.anchor));
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
    given.setZero(model.nv);
    loads.assign((size_t)model.njoints, pin::Force::Zero());
}

// Loads act at the centre of mass; Pinocchio wants them at the joint.
static void read_loads(int s)
{
    const double *own = peer_group(peer_loads, s, 6 * (size_t)peer_joints);
    for (size_t i = 0; i < (size_t)peer_joints; i++, own += 6) {
        const Eigen::Vector3d force(own), torque(own + 3), center(peer_joint_list[i].center);
        loads[i + 1] = pin::Force(force, torque + center.cross(force));
    }
}

static void peer_evaluate(int s)
{
    constexpr auto convention = pin::Convention::CONVENTION;
    const size_t n = (size_t)peer_joints;
    auto vector = [&](const double *storage) {
        return Eigen::Map<const Eigen::VectorXd>(peer_group(storage, s, n), (Eigen::Index)n);
    };
    q = vector(peer_q);
    v = vector(peer_qd);
    if (peer_wanted != PEER_DIRDYNA) given = vector(peer_given);
    if (peer_has_loads) read_loads(s);
    switch (peer_wanted) {
    case PEER_DIRDYNA:
        pin::crba(model, *data, q, convention);
        if (peer_has_loads)
            pin::rnea(model, *data, q, v, given, loads);
        else
            pin::nonLinearEffects(model, *data, q, v);
        break;
    case PEER_INVDYNA:
        if (peer_has_loads)
            pin::rnea(model, *data, q, v, given, loads);
        else
            pin::rnea(model, *data, q, v, given);
        break;
    case PEER_ACCELRED:
        if (peer_has_loads)
            pin::aba(model, *data, q, v, given, loads, convention);
        else
            pin::aba(model, *data, q, v, given, convention);
        break;
    case PEER_INVDYNA_D:
        if (peer_has_loads)
            pin::computeRNEADerivatives(model, *data, q, v, given, loads);
        else
            pin::computeRNEADerivatives(model, *data, q, v, given);
        break;
    case PEER_DIRDYNA_D:
        if (peer_has_loads)
            pin::computeABADerivatives(model, *data, q, v, given, loads);
        else
            pin::computeABADerivatives(model, *data, q, v, given);
    }
}

// Joints keep their numbers: parents come first, and so does Pinocchio count.
static void peer_result(int lane, double *out)
{
    const int n = peer_joints;
    (void)lane;
    auto place = [](int i) { return model.joints[(size_t)i + 1].idx_v(); };
    auto write = [&](const auto &matrix, bool half) {
        for (int i = 0; i < n; i++)
            for (int j = 0; j < n; j++) {
                const int row = place(i), column = place(j);
                *out++ = half && row > column ? matrix(column, row) : matrix(row, column);
            }
    };
    if (peer_wanted == PEER_INVDYNA_D) {
        write(data->dtau_dq, false);
        write(data->dtau_dv, false);
        return;
    }
    if (peer_wanted == PEER_DIRDYNA_D) {
        write(data->ddq_dq, false);
        write(data->ddq_dv, false);
        write(data->Minv, true);
        return;
    }
    if (peer_wanted != PEER_DIRDYNA) {
        const Eigen::VectorXd &found = peer_wanted == PEER_INVDYNA ? data->tau : data->ddq;
        for (int i = 0; i < n; i++) out[i] = found[place(i)];
        return;
    }
    const Eigen::VectorXd &forces = peer_has_loads ? data->tau : data->nle;
    write(data->M, true);
    for (int i = 0; i < n; i++) *out++ = forces[place(i)];
}

int main(int count, char **words)
{
    peer_read(count, words);
    build();
    return peer_main(count, words);
}
