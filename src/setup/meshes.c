#include "meshes.h"

#include "base/memory.h"
#include "comm/comm.h"
#include "geometry/mesh_file.h"
#include "geometry/revolution.h"
#include "geometry/surface_samples.h"
#include "setup/named_file.h"
#include "setup/source.h"
#include "setup/trace.h"
#include "setup/world_frame.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double max_cells = (double)((int64_t)1 << 31); /* of a coordinate from the scene's origin */

/* A block or wall with a surface. */
typedef struct entry {
  hc_source_name name; /* for messages */
  char path[64];       /* where findings point to */
  hc_form form;
  hc_mesh_input *mesh;
  const hc_revolution *revolution;
  bool closed, wall, fluid_inside;
  hc_made_surface *made;
} entry;

typedef struct loading {
  hc_comm *comm; /* null: alone */
  const char *scene_name;
  hc_findings *findings;
  hc_frame frame;
  double spacing; /* m */
  int layers;
} loading;

/* What rank 0 says of a mesh before the mesh itself. */
typedef struct header {
  hc_error error;
  char file[HC_FILE_LENGTH], checksum[HC_CHECKSUM_LENGTH];
  int32_t vertices, triangles;
  bool turned;
} header;

/* --- Files --- */

static hc_status read_mesh(const loading *l, const entry *e, header *h, hc_mesh *mesh) {
  uint64_t checksum;
  hc_error *const error = &h->error;
  *mesh = (hc_mesh){0};
  if (hc_named_file_find(l->scene_name, e->mesh->file, h->file, error) != HC_OK) return error->status;
  if (hc_mesh_file_read(h->file, mesh, &checksum, error) != HC_OK) return error->status;
  snprintf(h->checksum, sizeof h->checksum, "%016" PRIx64, checksum);
  if (e->mesh->checksum[0] && strcmp(e->mesh->checksum, h->checksum) != 0)
    return hc_error_set(
        error, HC_BAD_INPUT,
        "%s has the checksum %s, not %s: it has changed (leave mesh.checksum away to take it as "
        "it is)",
        h->file, h->checksum, e->mesh->checksum);
  const hc_rotation *const rotation = &e->mesh->rotation;
  hc_mesh_place(mesh, e->mesh->scale, rotation->axis, rotation->angle / 360, e->mesh->translation);
  hc_mesh_weld(mesh);
  hc_error found = {.status = HC_OK};
  if (hc_mesh_check(mesh, !e->closed, &h->turned, &found) == HC_OK) return HC_OK;
  return hc_error_set(
      error, HC_BAD_INPUT, "the mesh %s is broken: %.4000s%s", h->file, found.text,
      e->wall && e->closed && strstr(found.text, "not closed") ? "; sheets need mesh.closed: false" : "");
}

/* Rank 0's on all ranks. */
static void send_mesh(hc_comm *comm, header *h, hc_mesh *mesh) {
  h->vertices = mesh->vertex_count;
  h->triangles = mesh->triangle_count;
  hc_comm_broadcast(comm, h, sizeof *h, 0);
  if (h->error.status != HC_OK) return;
  if (comm->rank != 0) {
    *mesh = hc_mesh_make(h->vertices, h->triangles);
    mesh->neighbour = hc_alloc((size_t)h->triangles, sizeof *mesh->neighbour);
  }
  hc_comm_broadcast(comm, mesh->vertex, (size_t)h->vertices * sizeof *mesh->vertex, 0);
  hc_comm_broadcast(comm, mesh->triangle, (size_t)h->triangles * sizeof *mesh->triangle, 0);
  hc_comm_broadcast(comm, mesh->neighbour, (size_t)h->triangles * sizeof *mesh->neighbour, 0);
}

static hc_status load_mesh(const loading *l, const entry *e, hc_mesh *mesh, hc_error *error) {
  header *const h = hc_alloc_zero(1, sizeof *h);
  *mesh = (hc_mesh){0};
  if (!l->comm || l->comm->rank == 0) read_mesh(l, e, h, mesh);
  if (l->comm) send_mesh(l->comm, h, mesh);
  *error = h->error;
  if (error->status == HC_OK) {
    memcpy(e->mesh->file, h->file, sizeof h->file);
    memcpy(e->mesh->checksum, h->checksum, sizeof h->checksum);
    if (h->turned)
      hc_findings_warning(l->findings, e->path, "%s: the mesh %s is inside out and is turned around",
                          e->name.text, h->file);
  }
  hc_free(h);
  return error->status;
}

/* --- Surfaces --- */

static hc_status turn_profile(const loading *l, const entry *e, hc_mesh *mesh, hc_error *error) {
  const hc_revolution *const r = e->revolution;
  bool turned;
  hc_error found = {.status = HC_OK};
  if (hc_revolution_mesh(r->base, r->axis, (const double(*)[2])r->profile, r->profile_count, e->closed,
                         l->spacing, mesh, error) != HC_OK ||
      hc_mesh_check(mesh, !e->closed, &turned, &found) == HC_OK)
    return error->status;
  return hc_error_set(error, HC_BAD_INPUT, "the surface of revolution is broken: %.4000s", found.text);
}

/* Units that cannot be are the commonest mistake. */
static hc_status check_extent(const loading *l, const entry *e, const hc_mesh *mesh, hc_error *error) {
  const char *const hint =
      e->form == HC_FORM_MESH ? "is mesh.scale, the metres of a unit of the file, right?" : "is its unit m?";
  double low[3], high[3], extent = 0, farthest = 0;
  hc_mesh_bounds(mesh, low, high);
  for (int a = 0; a < 3; a++) {
    extent = fmax(extent, high[a] - low[a]);
    farthest = fmax(farthest, fmax(fabs(low[a]), fabs(high[a])));
  }
  if (!(farthest <= max_cells * l->frame.support_radius))
    return hc_error_set(error, HC_BAD_INPUT,
                        "it must lie within 2^31 support radii of the origin, and reaches out to %g m; %s",
                        farthest, hint);
  if (extent < l->spacing)
    return hc_error_set(error, HC_BAD_INPUT,
                        "it must be larger than particle_spacing (%g m), and is %g m large; %s", l->spacing,
                        extent, hint);
  return HC_OK;
}

static void gather(void *context, const void *mine, size_t bytes, void **all, size_t *total) {
  hc_comm_gather_all(context, mine, bytes, all, total);
}

hc_parts hc_setup_parts(hc_comm *comm) {
  return comm ? (hc_parts){comm->rank, comm->size, comm, gather} : hc_parts_alone;
}

static void make(const loading *l, const entry *e) {
  hc_mesh mesh = {0};
  hc_error *const error = hc_alloc_zero(1, sizeof *error);
  hc_surface *surface = NULL;
  if ((e->form == HC_FORM_MESH ? load_mesh : turn_profile)(l, e, &mesh, error) == HC_OK &&
      check_extent(l, e, &mesh, error) == HC_OK) {
    surface = hc_surface_make(&mesh, e->closed);
    const hc_parts parts = hc_setup_parts(l->comm);
    if (e->wall) hc_surface_samples_make(surface, l->spacing, l->layers, e->fluid_inside, &parts, error);
  }
  hc_mesh_free(&mesh);
  if (error->status != HC_OK) {
    hc_surface_free(surface);
    surface = NULL;
    hc_findings_error(l->findings, e->path, "%s: %s", e->name.text, error->text);
  }
  *e->made = (hc_made_surface){surface, hc_surface_free};
  hc_free(error);
}

static bool has_surface(hc_form form) {
  return form == HC_FORM_MESH || form == HC_FORM_REVOLUTION;
}

static void set_path(entry *e, const char *list, int number) {
  snprintf(e->path, sizeof e->path, "%s[%d].%s", list, number,
           e->form == HC_FORM_MESH ? "mesh.file" : "revolution.profile");
}

void hc_setup_meshes_load(void *context, hc_scene *scene, const char *name, hc_findings *findings) {
  loading l = {.comm = context, .scene_name = name, .findings = findings, .layers = hc_setup_layers(scene)};
  hc_error error;
  if (hc_setup_frame(scene, &l.frame, &error) != HC_OK) return;
  l.spacing = hc_trace_spacing(&l.frame);
  for (int k = 0; k < scene->fluid.block_count; k++) {
    hc_block *const block = &scene->fluid.blocks[k];
    if (!has_surface(block->form)) continue;
    entry e = {.name = hc_source_block_name(k),
               .form = block->form,
               .mesh = &block->mesh,
               .revolution = &block->revolution,
               .closed = true,
               .made = &block->made};
    set_path(&e, "fluid.blocks", k);
    make(&l, &e);
  }
  for (int k = 0; k < scene->boundary.wall_count; k++) {
    hc_wall *const wall = &scene->boundary.walls[k];
    if (!has_surface(wall->form)) continue;
    const bool closed = wall->form == HC_FORM_MESH ? wall->mesh.closed : wall->revolution.closed;
    entry e = {.name = hc_source_wall_name(wall, k),
               .form = wall->form,
               .mesh = &wall->mesh,
               .revolution = &wall->revolution,
               .closed = closed,
               .wall = true,
               .fluid_inside = closed && wall->inside == HC_INSIDE_FLUID,
               .made = &wall->made};
    set_path(&e, "boundary.walls", k);
    make(&l, &e);
  }
  for (int k = 0; k < scene->body_count; k++) {
    hc_wall *const surface = &scene->bodies[k].surface;
    if (!has_surface(surface->form)) continue;
    entry e = {.name = hc_source_body_name(&scene->bodies[k], k),
               .form = surface->form,
               .mesh = &surface->mesh,
               .revolution = &surface->revolution,
               .closed = true,
               .wall = true,
               .made = &surface->made};
    set_path(&e, "bodies", k);
    make(&l, &e);
  }
}
