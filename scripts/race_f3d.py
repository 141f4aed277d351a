"""First picture of a model by f3d, off screen, with transparency by dual depth peeling: what scripts/race runs beside us.

    race_f3d.py MODEL WIDTH HEIGHT PICTURE

Seen from the direction from which `pellucid render` sees a model by default, and framed by f3d itself.
"""

import sys

import f3d

model, width, height, picture = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4]
f3d.Engine.autoload_plugins()
engine = f3d.Engine.create(True)
engine.window.size = width, height
engine.options["render.effect.blending.mode"] = "ddp"
engine.options["model.color.opacity"] = 0.3
engine.options["ui.loader_progress"] = False
engine.scene.add(model)
camera = engine.window.camera
camera.reset_to_bounds()
x, y, z = camera.focal_point
distance = sum((a - b) ** 2 for a, b in zip(camera.position, camera.focal_point)) ** 0.5
camera.position = x + 0.519837 * distance, y + 0.422618 * distance, z + 0.742404 * distance
camera.view_up = 0, 1, 0
camera.reset_to_bounds()
engine.window.render_to_image().save(picture)
