/* MuJoCo: the stages of mj_forward and mj_inverse that give what is asked for
   without constraints, on a model that peer.h's text is turned into. Loads of
   bodies are not learnt: MuJoCo's are in the frame of the base.

   Joints without mass between two bodies become joints of one body, since
   MuJoCo wants every moving body to have a mass. */
#include "peer.h"
#include <mujoco/mujoco.h>

static mjModel *model;
static mjData *data;
static double *dense;

static int massless(const peer_joint *j)
{
    return j->mass == 0.0;
}

/* Where the frame of a joint at rest stands: columns of the turn are its axes. */
typedef struct {
    double turn[9], place[3];
} rest_frame;

/* The frame of a joint, given that of the joint before it. */
static rest_frame behind(const rest_frame *before, const peer_joint *j)
{
    rest_frame frame = *before;
    for (int r = 0; r < 3; r++) {
        const double *row = before->turn + 3 * r;
        for (int c = 0; c < 3; c++) {
            frame.place[r] += row[c] * j->anchor[c];
            frame.turn[3 * r + c] =
                row[0] * j->turn[c] + row[1] * j->turn[3 + c] + row[2] * j->turn[6 + c];
        }
    }
    return frame;
}

/* A joint as its body sees it. */
static void text_of_joint(FILE *out, int i, const rest_frame *own, const rest_frame *body)
{
    const peer_joint *j = &peer_joint_list[i];
    double axis[3] = {0, 0, 0}, place[3] = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        for (int r = 0; r < 3; r++) {
            axis[k] += body->turn[3 * r + k] * own->turn[3 * r + j->axis];
            place[k] += body->turn[3 * r + k] * (own->place[r] - body->place[r]);
        }
    fprintf(out,
            "<joint name='j%d' type='%s' axis='%.17g %.17g %.17g' pos='%.17g %.17g %.17g'/>\n", i,
            j->revolute ? "hinge" : "slide", axis[0], axis[1], axis[2], place[0], place[1],
            place[2]);
}

/* The last joint of the body that joint i begins: over massless joints that
   carry one joint only, and sit where their parent does. */
static int last_of_body(int i)
{
    for (;;) {
        int child = -1, children = 0;
        if (!massless(&peer_joint_list[i])) return i;
        for (int k = i + 1; k < peer_joints; k++)
            if (peer_joint_list[k].parent == i) child = k, children++;
        if (children != 1) return i;
        i = child;
    }
}

/* Writes the body that begins with joint i, and closes it. Bodies are written
   depth first with a stack of what is still to be written. */
static void text_of_body(FILE *out, int first, int last)
{
    rest_frame frames[PEER_MOST_JOINTS], frame = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}};
    int chain[PEER_MOST_JOINTS], length = 0;
    for (int i = last;; i = peer_joint_list[i].parent) {
        chain[length++] = i;
        if (i == first) break;
    }
    for (int k = length - 1; k >= 0; k--) {
        frame = behind(&frame, &peer_joint_list[chain[k]]);
        frames[k] = frame;
    }
    /* The body's frame is that of its last joint at rest. */
    const double *t = frame.turn, *d = frame.place;
    fprintf(out,
            "<body pos='%.17g %.17g %.17g' xyaxes='%.17g %.17g %.17g %.17g %.17g %.17g'>\n", d[0],
            d[1], d[2], t[0], t[3], t[6], t[1], t[4], t[7]);
    const peer_joint *j = &peer_joint_list[last];
    const double *c = j->center, *I = j->inertia;
    if (!massless(j))
        fprintf(out,
                "<inertial mass='%.17g' pos='%.17g %.17g %.17g' "
                "fullinertia='%.17g %.17g %.17g %.17g %.17g %.17g'/>\n",
                j->mass, c[0], c[1], c[2], I[0], I[3], I[5], I[1], I[2], I[4]);
    for (int k = length - 1; k >= 0; k--) text_of_joint(out, chain[k], &frames[k], &frame);
}

static char *text_of_model(void)
{
    char *text;
    size_t size;
    FILE *out = open_memstream(&text, &size);
    fprintf(out,
            "<mujoco><compiler angle='radian' inertiafromgeom='false' autolimits='false'/>"
            "<option gravity='%.17g %.17g %.17g'><flag contact='disable'/></option><worldbody>\n",
            peer_gravity[0], peer_gravity[1], peer_gravity[2]);
    int stack[2 * PEER_MOST_JOINTS], height = 0;
    for (int i = peer_joints - 1; i >= 0; i--)
        if (peer_joint_list[i].parent < 0) stack[height++] = i;
    while (height) {
        const int first = stack[--height];
        if (first < 0) {
            fprintf(out, "</body>\n");
            continue;
        }
        const int last = last_of_body(first);
        text_of_body(out, first, last);
        stack[height++] = -1;
        for (int k = peer_joints - 1; k > last; k--)
            if (peer_joint_list[k].parent == last) stack[height++] = k;
    }
    fprintf(out, "</worldbody></mujoco>\n");
    fclose(out);
    return text;
}

static int address[PEER_MOST_JOINTS];

static void build(const char *folder)
{
    char name[4096], message[1024] = "";
    snprintf(name, sizeof name, "%s.mujoco.xml", folder);
    char *text = text_of_model();
    FILE *file = fopen(name, "w");
    if (!file) bench_fail("the MuJoCo model cannot be written");
    fputs(text, file);
    fclose(file);
    free(text);
    model = mj_loadXML(name, 0, message, sizeof message);
    if (!model) bench_fail(message);
    data = mj_makeData(model);
    if (model->nv != peer_joints) bench_fail("MuJoCo sees another number of joints");
    dense = (double *)calloc((size_t)peer_joints * (size_t)peer_joints, sizeof(double));
    for (int i = 0; i < peer_joints; i++) {
        char joint[32];
        snprintf(joint, sizeof joint, "j%d", i);
        address[i] = model->jnt_dofadr[mj_name2id(model, mjOBJ_JOINT, joint)];
    }
}

static void peer_evaluate(int s)
{
    const size_t n = (size_t)peer_joints;
    const double *q = peer_group(peer_q, s, n), *qd = peer_group(peer_qd, s, n);
    const double *given = peer_wanted == PEER_DIRDYNA ? q : peer_group(peer_given, s, n);
    for (int i = 0; i < peer_joints; i++) {
        data->qpos[address[i]] = q[i];
        data->qvel[address[i]] = qd[i];
        if (peer_wanted == PEER_INVDYNA) data->qacc[address[i]] = given[i];
        if (peer_wanted == PEER_ACCELRED) data->qfrc_smooth[address[i]] = given[i];
    }
    mj_kinematics(model, data);
    mj_comPos(model, data);
    if (peer_wanted != PEER_INVDYNA) mj_makeM(model, data);
    if (peer_wanted == PEER_ACCELRED) mj_factorM(model, data);
    mj_comVel(model, data);
    mj_rne(model, data, peer_wanted == PEER_INVDYNA, data->qfrc_bias);
    if (peer_wanted != PEER_ACCELRED) return;
    for (int i = 0; i < peer_joints; i++) data->qfrc_smooth[i] -= data->qfrc_bias[i];
    mj_solveM(model, data, data->qacc, data->qfrc_smooth, 1);
}

static void peer_result(int lane, double *out)
{
    const int n = peer_joints;
    (void)lane;
    if (peer_wanted != PEER_DIRDYNA) {
        const double *found = peer_wanted == PEER_INVDYNA ? data->qfrc_bias : data->qacc;
        for (int i = 0; i < n; i++) out[i] = found[address[i]];
        return;
    }
    mj_fullM(model, data, dense);
    for (int i = 0; i < n; i++) {
        out[n * n + i] = data->qfrc_bias[address[i]];
        for (int j = 0; j < n; j++) out[i * n + j] = dense[address[i] * n + address[j]];
    }
}

int main(int count, char **words)
{
    peer_read(count, words);
    build(words[4]);
    return peer_main(count, words);
}
