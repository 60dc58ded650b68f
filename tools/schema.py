"""Write the packaged JSON Schemas, assets/schema/*.json, from the models: python tools/schema.py."""

import json

from uwsim.scenario.schema import FILES, schema, schema_file


def main() -> None:
    """Write all schemas."""
    for part in FILES:
        path = schema_file(part)
        path.parent.mkdir(exist_ok=True)
        path.write_text(json.dumps(schema(part), indent=1, sort_keys=True) + "\n")
        print(path)


main()
