// Renders the view that a model begins with: Picture.exe MODEL.pnerf PICTURE.ppm
//
// mcs Picture.cs Pocketnerf.cs Types.cs Native.cs && LD_LIBRARY_PATH=PREFIX/lib mono Picture.exe ...
using System;
using System.IO;
using System.Text;

namespace Pocketnerf.Samples
{
    internal static class Picture
    {
        private static int Main(string[] arguments)
        {
            if (arguments.Length != 2)
            {
                Console.Error.WriteLine("usage: Picture MODEL.pnerf PICTURE.ppm");
                return 2;
            }
            try
            {
                Write(arguments[0], arguments[1]);
                return 0;
            }
            catch (Exception error) when (error is PocketnerfException || error is IOException)
            {
                Console.Error.WriteLine("Picture: " + error.Message);
                return 1;
            }
        }

        private static void Write(string model, string path)
        {
            using (var scene = Model.Open(model))
            {
                var camera = scene.Camera();
                var pixels = new byte[4 * camera.Width * camera.Height];
                var target = new Target { Pixels = pixels, Background = scene.Info.Background };
                var stats = scene.Render(camera, target);
                using (var file = File.Create(path))
                {
                    var header = string.Format("P6\n{0} {1}\n255\n", camera.Width, camera.Height);
                    file.Write(Encoding.ASCII.GetBytes(header), 0, header.Length);
                    for (var at = 0; at < pixels.Length; at += 4) file.Write(pixels, at, 3);
                }
                Console.WriteLine("{0}: {1}x{2}, {3} samples", path, camera.Width, camera.Height,
                    stats.Samples);
            }
        }
    }
}
