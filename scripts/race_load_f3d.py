"""Loads a model with f3d, off screen, and takes the smallest useful picture: what scripts/race_load runs beside us.

    race_load_f3d.py MODEL PICTURE
"""

import sys

import f3d

model, picture = sys.argv[1], sys.argv[2]
f3d.Engine.autoload_plugins()
engine = f3d.Engine.create(True)
engine.window.size = 16, 16
engine.options["ui.loader_progress"] = False
engine.scene.add(model)
engine.window.camera.reset_to_bounds()
engine.window.render_to_image().save(picture)
