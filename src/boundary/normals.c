#include "normals.h"

#include <math.h>
#include <string.h>

static const double THIN = 1.2;    /* spacings between the samples of a wall's two sides */
static const double ROOM = 1.3;    /* spacings between samples that look at each other: none for fluid */
static const double AROUND = 1.25; /* spacings: where the faces are that meet at a sample */
static const double BENT = 0.85;   /* cosine between normals below which there are two faces */
static const double OFF = 0.4;     /* spacings: how far beyond the plane of a sample that other faces are */
static const double ASKEW = 0.3;   /* cosine beyond which normals have something to do with each other */
static const double LOWEST = 0.6;  /* spacings: how far ahead of a sample the foot of a face begins */

/* A sample and another one of its wall, or of one that it meets. */
typedef struct meeting {
  double square;       /* of their distance, in support radii */
  double alike;        /* cosine between the normals */
  double ahead;        /* of the other, along the sample's normal, */
  double before;       /* and of the sample, along the other's */
  const float *normal; /* the other's */
} meeting;

static meeting meet(const hc_sweep *sweep, const hc_particles *boundary, int32_t b, const float n[3],
                    uint32_t offset) {
  const size_t c = offset / sizeof(hc_record);
  meeting m = {.normal = boundary->facing[c].v};
  for (int axis = 0; axis < 3; axis++) {
    const int32_t units =
        (int32_t)((uint32_t)boundary->place[b].x[axis] - (uint32_t)boundary->place[c].x[axis]);
    const double d = (double)units * (double)sweep->scale[axis];
    m.square += d * d;
    m.alike += (double)n[axis] * (double)m.normal[axis];
    m.ahead -= d * (double)n[axis];
    m.before += d * (double)m.normal[axis];
  }
  return m;
}

static double spacings(const hc_sweep *sweep, double count) {
  return count * 2.0 * (double)sweep->wall_offset;
}

/* Does the wall's other side lie so near behind a sample that fluid in front of it feels both? */
static bool is_thin(const hc_sweep *sweep, const hc_particles *boundary, const hc_neighbors *list,
                    int32_t b) {
  const float *const n = boundary->facing[b].v;
  if (n[0] == 0.0f && n[1] == 0.0f && n[2] == 0.0f) return true;
  const double reach = spacings(sweep, THIN);
  const uint32_t *const row = hc_list_row(list, b);
  for (int32_t k = 0; k < hc_list_count(list, b); k++) {
    const meeting m = meet(sweep, boundary, b, n, row[k]);
    if (m.alike < -ASKEW && m.ahead <= 0.0 && m.square < reach * reach) return true;
  }
  return false;
}

/* The normal of a sample without what of it looks at another wall with no room for fluid between, as at the
 * bottom of a box on a floor; 0 where nothing is left. */
static void free_normal(const hc_sweep *sweep, const hc_particles *boundary, const hc_neighbors *list,
                        int32_t b, float normal[3]) {
  const float *const n = boundary->facing[b].v;
  memcpy(normal, n, 3 * sizeof *normal);
  const double reach = spacings(sweep, ROOM);
  const uint32_t *const row = hc_list_row(list, b);
  for (int32_t k = 0; k < hc_list_count(list, b); k++) {
    const meeting m = meet(sweep, boundary, b, n, row[k]);
    if (m.alike >= -ASKEW || m.ahead <= 0.0 || m.before <= 0.0 || m.square > reach * reach) continue;
    double left = 0.0;
    for (int axis = 0; axis < 3; axis++) left += (double)normal[axis] * (double)m.normal[axis];
    for (int axis = 0; axis < 3 && left < 0.0; axis++) normal[axis] -= (float)(left * (double)m.normal[axis]);
  }
  const float length = sqrtf(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  for (int axis = 0; axis < 3; axis++) normal[axis] = length > 0.1f ? normal[axis] / length : 0.0f;
}

/* Adds the normals of faces that stand on a sample's, as a box on a floor: there is the inner edge of both.
 */
static void add_feet(const hc_sweep *sweep, const hc_particles *boundary, const hc_neighbors *list, int32_t b,
                     float normal[3]) {
  const float *const n = boundary->facing[b].v;
  const double reach = spacings(sweep, ROOM), low = spacings(sweep, LOWEST), flush = spacings(sweep, OFF);
  const uint32_t *const row = hc_list_row(list, b);
  float sum[3] = {n[0], n[1], n[2]};
  bool any = false;
  for (int32_t k = 0; k < hc_list_count(list, b); k++) {
    const meeting m = meet(sweep, boundary, b, n, row[k]);
    double along = 0.0; /* of the part of the other's normal that lies in the sample's face */
    float part[3];
    if (m.square > reach * reach || m.ahead < low || fabs(m.before + m.alike * m.ahead) > flush) continue;
    for (int axis = 0; axis < 3; axis++) {
      part[axis] = m.normal[axis] - (float)m.alike * n[axis];
      along += (double)part[axis] * (double)sum[axis];
    }
    const double length = sqrt(fmax(0.0, 1.0 - m.alike * m.alike));
    if (length < ASKEW || along > 0.0) continue; /* none, or there already */
    for (int axis = 0; axis < 3; axis++) sum[axis] += part[axis] / (float)length;
    any = true;
  }
  const float length = sqrtf(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
  for (int axis = 0; axis < 3 && any && length > 0.1f; axis++) normal[axis] = sum[axis] / length;
}

/* The weight of a sample's normal: where faces meet, ahead or behind of it, the root of how long the sum of
 * their normals is. So a lattice a spacing from the walls of a right edge or corner has the rest density to
 * half a percent, and a box displaces its volume. Negative where they meet ahead, in an inner edge; its sign
 * alone says so where walls move. */
static float count_faces(const hc_sweep *sweep, const hc_particles *boundary, const hc_neighbors *list,
                         int32_t b, const float normal[3]) {
  const double reach = spacings(sweep, AROUND), aside = spacings(sweep, OFF);
  const uint32_t *const row = hc_list_row(list, b);
  double least = 1.0;
  bool inner = false;
  for (int32_t k = 0; k < hc_list_count(list, b); k++) {
    const meeting m = meet(sweep, boundary, b, normal, row[k]);
    if (m.square > reach * reach || m.alike <= ASKEW || m.alike >= BENT || fabs(m.ahead) <= aside) continue;
    least = fmin(least, m.alike);
    inner |= m.ahead > 0.0;
  }
  return (float)(inner ? -sqrt(1.0 / least) : sqrt(1.0 / least));
}

void hc_boundary_look_at_normals(const hc_sweep *sweep, hc_particles *boundary, const hc_neighbors *list) {
  for (int32_t b = 0; b < boundary->own; b++) {
    float *const normal = &boundary->normal[3 * (size_t)b];
    const bool thin = is_thin(sweep, boundary, list, b);
    if (!thin && !boundary->reference_normal) {
      free_normal(sweep, boundary, list, b, normal);
      add_feet(sweep, boundary, list, b, normal);
    }
    boundary->faces[b] = thin ? 0.0f : count_faces(sweep, boundary, list, b, normal);
    if (boundary->reference_normal && fabsf(boundary->faces[b]) > 1.0f)
      boundary->faces[b] = copysignf(0.0f, boundary->faces[b]);
  }
  for (int32_t b = 0; b < boundary->own; b++) {
    memcpy(boundary->facing[b].v, &boundary->normal[3 * (size_t)b], sizeof boundary->facing[b].v);
    boundary->facing[b].scalar = boundary->faces[b];
  }
}
